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

// Copying struct by struct: the block has its own layout, a local variable none.
void main() {
    uint n = 1u;
    LayoutStructs value;
    for (uint i = 0u; i < 2u; ++i) {
        fill_entry(n, value, i);
        all_structs.scene_header[i] = value.scene_header[i];
        all_structs.geometry[i] = value.geometry[i];
        all_structs.bvh_addresses[i] = value.bvh_addresses[i];
        all_structs.affine[i] = value.affine[i];
        all_structs.instance[i] = value.instance[i];
        all_structs.vertex_attributes[i] = value.vertex_attributes[i];
        all_structs.texture_entry[i] = value.texture_entry[i];
        all_structs.texture_ref[i] = value.texture_ref[i];
        all_structs.material[i] = value.material[i];
        all_structs.emitter[i] = value.emitter[i];
        all_structs.alias_entry[i] = value.alias_entry[i];
        all_structs.environment[i] = value.environment[i];
        all_structs.hit[i] = value.hit[i];
        all_structs.camera[i] = value.camera[i];
        all_structs.camera_motion[i] = value.camera_motion[i];
        all_structs.view_data[i] = value.view_data[i];
        all_structs.slice[i] = value.slice[i];
        all_structs.dumped_ray[i] = value.dumped_ray[i];
        all_structs.drawn_geometry[i] = value.drawn_geometry[i];
        all_structs.raster_counts[i] = value.raster_counts[i];
        all_structs.bvh_node[i] = value.bvh_node[i];
        all_structs.bvh_node_binary[i] = value.bvh_node_binary[i];
        all_structs.bvh_node_compact[i] = value.bvh_node_compact[i];
        all_structs.bvh_triangle[i] = value.bvh_triangle[i];
        all_structs.bvh_top_item[i] = value.bvh_top_item[i];
        all_structs.traversal_ray[i] = value.traversal_ray[i];
        all_structs.traversal_hit[i] = value.traversal_hit[i];
        all_structs.wavefront_ray[i] = value.wavefront_ray[i];
        all_structs.wavefront_hit[i] = value.wavefront_hit[i];
        all_structs.wavefront_path[i] = value.wavefront_path[i];
        all_structs.wavefront_extra[i] = value.wavefront_extra[i];
        all_structs.wavefront_slot[i] = value.wavefront_slot[i];
        all_structs.wavefront_vertex[i] = value.wavefront_vertex[i];
        all_structs.wavefront_shadow_ray[i] = value.wavefront_shadow_ray[i];
        all_structs.wavefront_split[i] = value.wavefront_split[i];
        all_structs.wavefront_class_sums[i] = value.wavefront_class_sums[i];
        all_structs.wavefront_size[i] = value.wavefront_size[i];
        all_structs.wavefront_first[i] = value.wavefront_first[i];
        all_structs.tile_sample[i] = value.tile_sample[i];
        all_structs.packed_light[i] = value.packed_light[i];
        all_structs.realtime_frame[i] = value.realtime_frame[i];
        all_structs.light_path[i] = value.light_path[i];
        all_structs.light_path_inside[i] = value.light_path_inside[i];
        all_structs.light_pending[i] = value.light_pending[i];
        all_structs.light_sums[i] = value.light_sums[i];
        all_structs.cache_frame_data[i] = value.cache_frame_data[i];
        all_structs.cache_size[i] = value.cache_size[i];
        all_structs.cache_update[i] = value.cache_update[i];
        all_structs.cache_path[i] = value.cache_path[i];
        all_structs.work_chunk[i] = value.work_chunk[i];
        all_structs.joint_influence[i] = value.joint_influence[i];
        all_structs.active_target[i] = value.active_target[i];
        all_structs.deform_job[i] = value.deform_job[i];
    }
}
