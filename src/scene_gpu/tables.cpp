// The second and third step: rows that refer to what is on the device, and the moment in which they become the scene.
#include <utility>

#include "base/error.h"
#include "sampling/blue_noise.h"
#include "sampling/sobol.h"
#include "scene_gpu/bsdf_tables.h"
#include "scene_gpu/state.h"

namespace parhelion {

// The scene as it is now. What is unchanged stays where it is.
void SceneGpu::State::make_tables() {
    make_sampler_tables();
    if (!bsdf_tables) bsdf_tables = make_table("bsdf_tables", bsdf_table_words());
    make_materials();
    make_environment();
    make_textures();
    make_triangle_tables();
    make_geometries();
    place_instances();
    place_emitters();
    table_rows_done = 0;
    tables_running = true;
    tables_edited = edited;
    tables_advance = anything_stale;
    anything_stale = materials_stale = textures_stale = environment_table_stale = edited = moved_by_compaction = false;
}

void SceneGpu::State::make_sampler_tables() {
    if (sampler_tables) return;
    std::vector<uint32_t> rows = sampling::sobol_table();
    const std::vector<uint32_t> tile = sampling::blue_noise_words();
    rows.insert(rows.end(), tile.begin(), tile.end());
    sampler_tables = make_table("sampler_tables", std::move(rows));
}

// Time goes on with an edit, and when nothing follows one: then the present becomes the previous frame, which stays traceable. Bottom
// levels that have gone elsewhere change nothing but the present.
void SceneGpu::State::publish(Frame& frame) {
    if (uses_hardware()) {
        next.tlas = gpu::AccelStruct::top(device, "accel/top", std::max(1u, tlas_count));
        frame.build_tlas(next.tlas, tlas_instances, tlas_count, next.kept);
    }
    if (tables_advance) before = has_no_past ? TopLevel{} : std::move(now);
    has_no_past = false;
    now = std::move(next);
    next = {};
    drawn_now = std::move(drawn_next);
    published += tables_advance ? 1 : 0;
    version += tables_edited ? 1 : 0;
    light_switches += std::exchange(light_switched, false) ? 1 : 0;
    unsettled |= tables_edited;
    frame_began = false;
    write_header(frame);
    tables.clear();
    tables_running = false;
    forget_unwanted();
}

// A set that neither a frame on its way nor anybody else holds: drivers that make it as large as its layout allows take milliseconds.
gpu::SceneSet SceneGpu::State::free_set(uint32_t textures) {
    std::erase_if(sets, [&](const gpu::SceneSet& set) { return set.max_textures() != textures; });
    for (const gpu::SceneSet& set : sets)
        if (set.data().use_count() == 1) return set;
    sets.emplace_back(device, "scene/set", textures);
    return sets.back();
}

namespace {
uint64_t address(const gpu::Buffer& buffer) { return buffer ? buffer.address() : 0; }
}  // namespace

void SceneGpu::State::write_header(Frame& frame) {
    const bool still = tables_advance ? !tables_edited : shown_header.moving == 0;
    shared::SceneHeader& header = shown_header = {};
    header.instances = address(instance_table);
    header.geometries = address(geometry_table);
    header.materials = address(material_table);
    header.textures = address(texture_table);
    header.geometry_emitters = address(geometry_emitters);
    header.emitters = address(emitter_table);
    header.emitter_table = address(emitter_alias);
    header.triangle_tables = address(triangle_alias);
    header.environment_table = address(environment_alias);
    header.bottom_nodes = address(bottom_nodes.buffer());
    header.bottom_triangles = address(bottom_triangles.buffer());
    header.top_nodes = address(now.nodes);
    header.top_items = address(now.items);
    header.sobol = address(sampler_tables);
    header.blue_noise = address(sampler_tables) + sampling::sobol_table().size() * sizeof(uint32_t);
    header.bsdf_tables = address(bsdf_tables);
    header.suns = address(suns);
    header.instance_before_of_now = address(instance_translation);
    header.emitter_now_of_before = address(emitter_translation);
    header.emitter_lit_before = address(emitter_lit_before);
    header.instance_before_count = instances_before;
    header.emitter_before_count = emitters_before;
    header.moving = 1;
    header.sun_count = static_cast<uint32_t>(sun_rows.size());
    header.emitter_count = static_cast<uint32_t>(emitters.size());
    header.culling = options.culling ? 1 : 0;
    header.features = features_shown = features;
    header.environment = environment;
    shown_instances = static_cast<uint32_t>(instances.size());
    if (still) become_past();

    shown_slots = slots;
    shown_buffers = geometry_buffers();
    for (const gpu::Buffer& buffer : {geometry_table, material_table, texture_table, instance_table, emitter_table, emitter_alias, triangle_alias, geometry_emitters,
                                      environment_alias, suns, sampler_tables, bsdf_tables, bottom_nodes.buffer(), bottom_triangles.buffer(), instance_translation, emitter_translation, emitter_lit_before})
        if (buffer) shown_buffers.push_back(buffer);
    binding.textures.clear();
    for (const auto& [key, image] : images)
        if (image.wanted) binding.textures.push_back(image.image);
    if (environment_image.image) binding.textures.push_back(environment_image.image);
    bind_shown(frame);
}

// The scene that is shown has become its own previous frame.
void SceneGpu::State::become_past() {
    before = {};
    shown_header.moving = 0;
    shown_header.instance_before_of_now = shown_header.emitter_now_of_before = shown_header.emitter_lit_before = 0;
    shown_header.instance_before_count = shown_instances;
    shown_header.emitter_before_count = shown_header.emitter_count;
}

// A frame goes by in which what comes next is not there yet.
void SceneGpu::State::settle(Frame& frame) {
    if (!frame_began || published == 0 || shown_header.moving == 0) return;
    frame_began = false;
    become_past();
    bind_shown(frame);
}

// Header and set 0 are written anew: the previous frame's may still be in use.
void SceneGpu::State::bind_shown(Frame& frame) {
    const TopLevel& past = before.tlas || before.nodes ? before : now;
    shown_header.top_nodes_before = address(past.nodes);
    shown_header.top_items_before = address(past.items);
    const gpu::Buffer block(device, "scene/header", sizeof(shown_header));
    frame.upload(block, 0, std::as_bytes(std::span(&shown_header, 1)));
    gpu::SceneSet set = free_set(std::max<uint32_t>(1, static_cast<uint32_t>(shown_slots.size())));
    set.set_header(block);
    for (uint32_t slot = 0; slot < shown_slots.size(); ++slot) set.set_texture(slot, shown_slots[slot].first, shown_slots[slot].second);
    if (uses_hardware()) set.set_accel(now.tlas, past.tlas);

    binding = {.set = set,
               .buffers = shown_buffers,
               .textures = std::move(binding.textures),
               .accels = {},
               .bvh_variant = traversal_variant(device->caps(), layout, options.bvh_loop, now.plain && past.plain)};
    for (const gpu::Buffer& buffer : {block, now.nodes, now.items, past.nodes, past.items})
        if (buffer) binding.buffers.push_back(buffer);
    if (!uses_hardware()) return;
    binding.accels = {now.tlas, past.tlas};
    for (const TopLevel* level : {static_cast<const TopLevel*>(&now), &past}) binding.accels.insert(binding.accels.end(), level->kept.begin(), level->kept.end());
}

}  // namespace parhelion
