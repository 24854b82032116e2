// Writes 1, 2, 3, ... into all fields of the structs of shaders/shared, in order: the same code on the host and in layout.comp.
#ifndef PARHELION_TEST_LAYOUT_FILL_H
#define PARHELION_TEST_LAYOUT_FILL_H
#include "shared/bvh.h"
#include "shared/cache.h"
#include "shared/chunks.h"
#include "shared/deform.h"
#include "shared/functions.h"
#include "shared/hit.h"
#include "shared/raster.h"
#include "shared/reference.h"
#include "shared/scene.h"
#include "shared/view.h"
#include "shared/realtime.h"
#include "shared/reservoir.h"
#include "shared/wavefront.h"
SHARED_BEGIN

struct LayoutStructs {
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
    WavefrontControl wavefront_control[2];  // stays zero: its hundreds of counters would take minutes to compile; its members' places are reflected
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
    CacheHeader cache_header[2];  // stays zero too
    CacheFrameData cache_frame_data[2];
    CacheSize cache_size[2];
    CacheUpdate cache_update[2];
    CachePath cache_path[2];
    WorkChunk work_chunk[2];
    JointInfluence joint_influence[2];
    ActiveTarget active_target[2];
    DeformJob deform_job[2];
};

SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(uint) v) { v = n++; }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(int) v) { v = int(n++); }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(float) v) { v = float(n++); }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(uint64_t) v) { v = uint64_t(n) << 32 | uint64_t(n + 7u); ++n; }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(vec2) v) { for (int i = 0; i < 2; ++i) v[i] = float(n++); }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(vec3) v) { for (int i = 0; i < 3; ++i) v[i] = float(n++); }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(vec4) v) { for (int i = 0; i < 4; ++i) v[i] = float(n++); }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(uvec2) v) { for (int i = 0; i < 2; ++i) v[i] = n++; }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(uvec4) v) { for (int i = 0; i < 4; ++i) v[i] = n++; }
#define F(member) fill(n, v.member);

SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Affine) v) { F(row0) F(row1) F(row2) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Instance) v) {
    F(world_from_object) F(object_from_world) F(world_from_object_before) F(geometry_base) F(geometry_base_before) F(geometry_count) F(emitter_base) F(flags) F(mask)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Geometry) v) {
    F(positions) F(indices) F(attributes) F(proxy_heights) F(triangle_count) F(vertex_count) F(material) F(flags) F(triangle_table)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(VertexAttributes) v) { F(normal) F(tangent) F(uv0) F(uv1) F(color) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(TextureEntry) v) { F(slot) F(width) F(height) F(level_count) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(TextureRef) v) { F(texture) F(uv_set) F(row0) F(row1) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Material) v) {
    F(base_color) F(emission) F(metallic) F(roughness) F(normal_scale) F(alpha_cutoff) F(ior) F(transmission) F(specular) F(specular_color) F(flags)
    F(absorption) F(priority) F(coat) F(coat_roughness) F(coat_normal_scale) F(sheen_color) F(sheen_roughness)
    F(base_color_texture) F(metal_rough_texture) F(normal_texture) F(emissive_texture) F(specular_texture) F(specular_color_texture)
    F(transmission_texture) F(coat_texture) F(coat_roughness_texture) F(coat_normal_texture) F(sheen_color_texture) F(sheen_roughness_texture)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Emitter) v) {
    F(kind) F(instance) F(geometry) F(triangle_count) F(triangle_table) F(position_ws) F(direction_ws) F(intensity) F(cos_inner) F(cos_outer) F(opening)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(AliasEntry) v) { F(probability) F(alias) F(pmf) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Environment) v) {
    F(scale) F(texture) F(rotation_sin) F(rotation_cos) F(table_width) F(table_height) F(emitter)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(SceneHeader) v) {
    F(instances) F(geometries) F(materials) F(textures) F(geometry_emitters) F(emitters) F(emitter_table) F(triangle_tables) F(environment_table)
    F(bottom_nodes) F(bottom_triangles) F(top_nodes) F(top_items) F(top_nodes_before) F(top_items_before) F(sobol) F(blue_noise)
    F(bsdf_tables) F(suns) F(instance_before_of_now) F(emitter_now_of_before) F(emitter_lit_before) F(instance_before_count) F(emitter_before_count)
    F(moving) F(emitter_count) F(sun_count) F(culling) F(features) F(environment)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Hit) v) { F(instance_bits) F(geometry) F(primitive) F(barycentrics) F(t) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Camera) v) { F(position_ws) F(right_ws) F(up_ws) F(forward_ws) F(orthographic) F(lens_radius) F(focus_distance) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(CameraMotion) v) { F(translation_ws) F(axis_ws) F(half_angle) F(zoom) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(ViewData) v) {
    F(camera) F(camera_before) F(motion) F(width) F(height) F(seed) F(sampler_kind) F(max_bounces) F(pixel_filter) F(roulette_start) F(light_sampling) F(flags) F(firefly_clamp)
    F(pixel_width) F(pixel_spread) F(jitter) F(jitter_before)
    for (uint i = 0u; i < kFilmGroupCount; ++i) F(channel[i])
    F(channel_count)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(Slice) v) { F(first_row) F(row_count) F(first_sample) F(sample_count) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(DumpedRay) v) { F(origin_ws) F(reach) F(direction_ws) F(alpha_key) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(DrawnGeometry) v) { F(instance) F(geometry) F(lower) F(upper) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(RasterCounts) v) {
    for (uint i = 0u; i < 6u; ++i) F(drawn[i])
    F(far_bits)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(BvhNode) v) { F(min_x) F(max_x) F(min_y) F(max_y) F(min_z) F(max_z) F(child) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(BvhNodeBinary) v) { F(x) F(y) F(z) F(child) F(pad) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(BvhNodeCompact) v) { F(origin) F(min_x) F(scale) F(max_x) F(min_y) F(max_y) F(min_z) F(max_z) F(child) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(BvhTriangle) v) { F(p0) F(p1) F(p2) F(rest) F(geometry) F(primitive) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(BvhTopItem) v) { F(row0) F(instance) F(row1) F(root) F(row2) F(mask) F(origin_ws) F(flags) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(BvhAddresses) v) { F(top_nodes) F(top_items) F(bottom_nodes) F(bottom_triangles) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(TraversalRay) v) { F(origin_ws) F(t_min) F(direction_ws) F(t_max) F(mask) F(alpha_key) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(TraversalHit) v) { F(instance) F(geometry) F(primitive) F(barycentrics) F(t) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontRay) v) { F(origin_ws) F(alpha_key) F(direction_ws) F(bits) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontHit) v) { F(instance_bits) F(geometry) F(primitive) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontPath) v) { F(throughput) F(pdf) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontExtra) v) { F(media) F(travelled) F(radiance_scale) F(cone_width) F(cone_spread) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontSlot) v) { F(radiance) F(path) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontVertex) v) { F(arriving) F(bits) F(sampled) F(path) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontShadowRay) v) { F(origin_ws) F(t_max) F(direction_ws) F(alpha_key) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontSplit) v) { F(diffuse_share) F(diffuse) F(specular) F(transmission) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontClassSums) v) { F(emission) F(direct_diffuse) F(direct_specular) F(indirect_diffuse) F(indirect_specular) F(transmission) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontFirst) v) { F(albedo) F(normal_ws) F(emission) F(roughness) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WavefrontSize) v) { F(x) F(y) F(z) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(TileSample) v) { F(place_ws) F(normal) F(bits) F(inverse_pdf) F(emitter) F(triangle) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(PackedLight) v) { F(low) F(high) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(RealtimeFrame) v) { F(frame_index) F(exposure) F(candidates) F(tiles) F(path_bounces) F(follows) F(reservoir_sets) F(later_candidates) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(LightPath) v) {
    F(throughput) F(pdf) F(diffuse_share) F(travelled) F(cone_width) F(cone_spread) F(way) F(lobes)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(LightPathInside) v) { F(media) F(radiance_scale) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(LightPending) v) { F(diffuse) F(pixel) F(specular) F(kind) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(LightSums) v) { F(diffuse) F(specular) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(PackedSample) v) { F(reference) F(number) F(place) F(bits) F(direction) F(radiance) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(PackedReservoir) v) { F(point) F(weight) F(target) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(ChosenSample) v) { F(reservoir) F(weight) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(LightReuse) v) { F(prefix) F(share) F(direction) F(instance) F(number) F(place) F(bits) F(density) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(ReuseFrame) v) { F(frame_index) F(set) F(candidates) F(most_confidence) F(neighbours) F(radius_px) F(permutation) F(reset) F(changed) F(keeps_offered) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(CacheFrameData) v) {
    F(frame_index) F(seed) F(exposure) F(exposure_ratio) F(cell_scale) F(cell_pixels) F(jitter) F(life) F(most_samples) F(candidates) F(forgets)
}
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(CacheSize) v) { F(x) F(y) F(z) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(CacheUpdate) v) { F(found) F(link) F(share) F(sum) F(otherwise) F(target) F(value) F(bits) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(CachePath) v) { F(throughput) F(pdf) F(media) F(travelled) F(radiance_scale) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(WorkChunk) v) { F(job) F(first) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(JointInfluence) v) { F(joint) F(weight) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(ActiveTarget) v) { F(positions) F(normals) F(tangents) F(weight) }
SHARED_FN void fill(SHARED_INOUT(uint) n, SHARED_INOUT(DeformJob) v) {
    F(rest_positions) F(rest_attributes) F(positions) F(attributes) F(influences) F(vertex_count) F(influence_count) F(joint) F(target) F(target_count)
}

// Entry i of every array.
SHARED_FN void fill_entry(SHARED_INOUT(uint) n, SHARED_INOUT(LayoutStructs) v, uint i) {
    F(scene_header[i]) F(geometry[i]) F(bvh_addresses[i]) F(affine[i]) F(instance[i]) F(vertex_attributes[i]) F(texture_entry[i]) F(texture_ref[i]) F(material[i]) F(emitter[i])
    F(alias_entry[i]) F(environment[i]) F(hit[i]) F(camera[i]) F(camera_motion[i]) F(view_data[i]) F(slice[i]) F(dumped_ray[i]) F(drawn_geometry[i]) F(raster_counts[i]) F(bvh_node[i]) F(bvh_node_binary[i]) F(bvh_node_compact[i]) F(bvh_triangle[i]) F(bvh_top_item[i])
    F(traversal_ray[i]) F(traversal_hit[i])
    F(wavefront_ray[i]) F(wavefront_hit[i]) F(wavefront_path[i]) F(wavefront_extra[i]) F(wavefront_slot[i]) F(wavefront_vertex[i]) F(wavefront_shadow_ray[i]) F(wavefront_split[i]) F(wavefront_class_sums[i]) F(wavefront_size[i]) F(wavefront_first[i]) F(tile_sample[i]) F(packed_light[i]) F(realtime_frame[i]) F(light_path[i]) F(light_path_inside[i]) F(light_pending[i]) F(light_sums[i]) F(packed_sample[i]) F(packed_reservoir[i]) F(chosen_sample[i]) F(light_reuse[i]) F(reuse_frame[i])
    F(cache_frame_data[i]) F(cache_size[i]) F(cache_update[i]) F(cache_path[i]) F(work_chunk[i]) F(joint_influence[i]) F(active_target[i]) F(deform_job[i])
}
#undef F

SHARED_END
#endif
