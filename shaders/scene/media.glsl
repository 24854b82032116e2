// The volumes that a path is in: nested dielectrics by priority. Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced
// Images". Only scenes with LAYERS have any; the camera is taken to be in air.
#ifndef PARHELION_SCENE_MEDIA_GLSL
#define PARHELION_SCENE_MEDIA_GLSL
#include "lib/bsdf.glsl"
#include "scene/scene.glsl"

// Materials of the volumes in the order in which they were entered, kNone behind the last. A fifth one is not noticed.
struct MediumStack {
    uvec4 materials;
};
MediumStack make_medium_stack() { return MediumStack(uvec4(kNone)); }

// The volume that is there: of the highest priority, and of equal ones that which was entered last. kNone: air.
uint medium_there(MediumStack stack) {
    uint there = kNone;
    int priority = 0;
    for (uint i = 0u; i < 4u; ++i) {
        const uint material = stack.materials[i];
        if (material == kNone) break;
        const int own = scene_material(material).priority;
        if (there != kNone && own < priority) continue;
        there = material;
        priority = own;
    }
    return there;
}

MediumStack enter_medium(MediumStack stack, uint material) {
    for (uint i = 0u; i < 4u; ++i)
        if (stack.materials[i] == kNone) {
            stack.materials[i] = material;
            break;
        }
    return stack;
}

// Forgets the last entry into the volume; nothing, if the path was not in it (it began there, or the mesh is not closed).
MediumStack leave_medium(MediumStack stack, uint material) {
    uint last = kNone;
    for (uint i = 0u; i < 4u; ++i)
        if (stack.materials[i] == material) last = i;
    if (last == kNone) return stack;
    for (uint i = last; i < 3u; ++i) stack.materials[i] = stack.materials[i + 1u];
    stack.materials[3] = kNone;
    return stack;
}

float medium_ior(uint material) { return material == kNone ? 1.0 : scene_material(material).ior; }

// What is left of light after a way through a volume: Beer and Lambert. An infinite way is dark but for what does not absorb.
vec3 medium_transmittance(uint material, float distance) {
    if (material == kNone) return vec3(1.0);
    const vec3 absorption = scene_material(material).absorption;
    return mix(exp(-absorption * distance), vec3(1.0), equal(absorption, vec3(0.0)));
}

// The boundary of a volume as a path meets it.
struct MediumBoundary {
    MediumStack beyond;  // volumes behind it
    bool real;           // false: another volume of higher priority is on both sides, and nothing happens
    float eta;           // index of refraction behind it over that before it
};

MediumBoundary cross_boundary(MediumStack stack, uint material, bool entering) {
    MediumBoundary boundary;
    boundary.beyond = entering ? enter_medium(stack, material) : leave_medium(stack, material);
    const uint before = medium_there(stack), behind = medium_there(boundary.beyond);
    // A path that leaves what it never entered was inside all the time; but where the stack is full, that is a volume which found
    // no room in it, and whose other side did not count either.
    const bool unknown = !entering && boundary.beyond.materials == stack.materials && stack.materials[3] == kNone;
    boundary.real = unknown || before != behind;
    boundary.eta = medium_ior(behind) / medium_ior(unknown ? material : before);
    return boundary;
}
#endif
