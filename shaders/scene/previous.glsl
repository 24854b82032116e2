// The previous frame's scene: where instances stood, and which rows of its tables are which of this frame's. What a frame keeps for the
// next (reservoirs, identities of pixels, ids of lights) names rows of its own frame; the next one translates them before it looks
// anything up. Triangles of an emitter keep their numbers.
#ifndef PARHELION_SCENE_PREVIOUS_GLSL
#define PARHELION_SCENE_PREVIOUS_GLSL
#include "scene/scene.glsl"

// World from object, a frame ago. Of a row that this frame does not draw but the previous one did: where it stood last.
Affine placement_before(uint instance) {
    if (scene.header.moving == 0u) return scene_instance(instance).world_from_object;
    return scene_instance(instance).world_from_object_before;
}

// The first geometry of its mesh as that was deformed a frame ago: the vertices of now, where they were. Likewise for a row that this frame
// does not draw.
uint geometry_base_before(uint instance) {
    if (scene.header.moving == 0u) return scene_instance(instance).geometry_base;
    return scene_instance(instance).geometry_base_before;
}

// The previous frame's row of this frame's instance; kNone: it is new.
uint instance_before(uint instance) {
    if (instance >= scene.header.instance_before_count) return kNone;
    return scene.header.instance_before_of_now == 0ul ? instance : UintArray(scene.header.instance_before_of_now).v[instance];
}

// This frame's row of the previous frame's instance; kNone: it is gone. An instance keeps its row while it is drawn, and a row that it
// leaves stays empty for a frame: so the table reads both ways.
uint instance_now(uint instance_before_row) { return instance_before(instance_before_row); }

// This frame's row of the previous frame's emitter; kNone: it is gone, or shines no more.
uint emitter_now(uint emitter_before_row) {
    if (emitter_before_row >= scene.header.emitter_before_count) return kNone;
    return scene.header.emitter_now_of_before == 0ul ? emitter_before_row : UintArray(scene.header.emitter_now_of_before).v[emitter_before_row];
}

// Its radiance in the previous frame over what it is now; 0: it was not there.
float lit_before(uint emitter) {
    if (scene.header.emitter_lit_before == 0ul || emitter >= scene.header.emitter_count) return 1.0;
    return uintBitsToFloat(UintArray(scene.header.emitter_lit_before).v[emitter]);
}
#endif
