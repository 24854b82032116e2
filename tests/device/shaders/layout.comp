#version 460
// Test shader: fills every struct of shaders/shared with known numbers. Writes: all.
#extension GL_GOOGLE_include_directive : require
#include "layout_fill.h"

layout(local_size_x = 1) in;
layout(set = 1, binding = 0, scalar) buffer AllStructs {
    SceneHeader scene_header[2];
    Geometry geometry[2];
    BvhAddresses bvh_addresses[2];
    Affine affine[2];
    Instance instance[2];
    VertexAttributes vertex_attributes[2];
    TextureEntry texture_entry[2];
    TextureRef texture_ref[2];
    Material material[2];
    Emitter emitter[2];
    AliasEntry alias_entry[2];
    Environment environment[2];
    Hit hit[2];
    Camera camera[2];
    CameraMotion camera_motion[2];
    ViewData view_data[2];
    Slice slice[2];
    DumpedRay dumped_ray[2];
    DrawnGeometry drawn_geometry[2];
    RasterCounts raster_counts[2];
    BvhNode bvh_node[2];
    BvhNodeBinary bvh_node_binary[2];
    BvhNodeCompact bvh_node_compact[2];
    BvhTriangle bvh_triangle[2];
    BvhTopItem bvh_top_item[2];
    TraversalRay traversal_ray[2];
    TraversalHit traversal_hit[2];
    WavefrontRay wavefront_ray[2];
    WavefrontHit wavefront_hit[2];
    WavefrontPath wavefront_path[2];
    WavefrontExtra wavefront_extra[2];
    WavefrontSlot wavefront_slot[2];
    WavefrontVertex wavefront_vertex[2];
    WavefrontShadowRay wavefront_shadow_ray[2];
    WavefrontSplit wavefront_split[2];
    WavefrontClassSums wavefront_class_sums[2];
    WavefrontControl wavefront_control[2];
    WavefrontSize wavefront_size[2];
    WavefrontFirst wavefront_first[2];
    TileSample tile_sample[2];
    PackedLight packed_light[2];
    RealtimeFrame realtime_frame[2];
    LightPath light_path[2];
    LightPathInside light_path_inside[2];
    LightPending light_pending[2];
    LightSums light_sums[2];
    PackedSample packed_sample[2];
    PackedReservoir packed_reservoir[2];
    ChosenSample chosen_sample[2];
    LightReuse light_reuse[2];
    ReuseFrame reuse_frame[2];
    CacheHeader cache_header[2];
    CacheFrameData cache_frame_data[2];
    CacheSize cache_size[2];
    CacheUpdate cache_update[2];
    CachePath cache_path[2];
    WorkChunk work_chunk[2];
    JointInfluence joint_influence[2];
    ActiveTarget active_target[2];
    DeformJob deform_job[2];
} all_structs;

// Struct by struct, in the order of fill_entry(): the block has its own layout, a local variable none.
#define WRITE(Struct, member)         \
    {                                 \
        Struct one;                   \
        fill(n, one);                 \
        all_structs.member[i] = one;  \
    }

void main() {
    uint n = 1u;
    for (uint i = 0u; i < 2u; ++i) {
        WRITE(SceneHeader, scene_header)
        WRITE(Geometry, geometry)
        WRITE(BvhAddresses, bvh_addresses)
        WRITE(Affine, affine)
        WRITE(Instance, instance)
        WRITE(VertexAttributes, vertex_attributes)
        WRITE(TextureEntry, texture_entry)
        WRITE(TextureRef, texture_ref)
        WRITE(Material, material)
        WRITE(Emitter, emitter)
        WRITE(AliasEntry, alias_entry)
        WRITE(Environment, environment)
        WRITE(Hit, hit)
        WRITE(Camera, camera)
        WRITE(CameraMotion, camera_motion)
        WRITE(ViewData, view_data)
        WRITE(Slice, slice)
        WRITE(DumpedRay, dumped_ray)
        WRITE(DrawnGeometry, drawn_geometry)
        WRITE(RasterCounts, raster_counts)
        WRITE(BvhNode, bvh_node)
        WRITE(BvhNodeBinary, bvh_node_binary)
        WRITE(BvhNodeCompact, bvh_node_compact)
        WRITE(BvhTriangle, bvh_triangle)
        WRITE(BvhTopItem, bvh_top_item)
        WRITE(TraversalRay, traversal_ray)
        WRITE(TraversalHit, traversal_hit)
        WRITE(WavefrontRay, wavefront_ray)
        WRITE(WavefrontHit, wavefront_hit)
        WRITE(WavefrontPath, wavefront_path)
        WRITE(WavefrontExtra, wavefront_extra)
        WRITE(WavefrontSlot, wavefront_slot)
        WRITE(WavefrontVertex, wavefront_vertex)
        WRITE(WavefrontShadowRay, wavefront_shadow_ray)
        WRITE(WavefrontSplit, wavefront_split)
        WRITE(WavefrontClassSums, wavefront_class_sums)
        WRITE(WavefrontSize, wavefront_size)
        WRITE(WavefrontFirst, wavefront_first)
        WRITE(TileSample, tile_sample)
        WRITE(PackedLight, packed_light)
        WRITE(RealtimeFrame, realtime_frame)
        WRITE(LightPath, light_path)
        WRITE(LightPathInside, light_path_inside)
        WRITE(LightPending, light_pending)
        WRITE(LightSums, light_sums)
        WRITE(PackedSample, packed_sample)
        WRITE(PackedReservoir, packed_reservoir)
        WRITE(ChosenSample, chosen_sample)
        WRITE(LightReuse, light_reuse)
        WRITE(ReuseFrame, reuse_frame)
        WRITE(CacheFrameData, cache_frame_data)
        WRITE(CacheSize, cache_size)
        WRITE(CacheUpdate, cache_update)
        WRITE(CachePath, cache_path)
        WRITE(WorkChunk, work_chunk)
        WRITE(JointInfluence, joint_influence)
        WRITE(ActiveTarget, active_target)
        WRITE(DeformJob, deform_job)
    }
}
