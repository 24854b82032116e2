// How fast light changes around a place of the last frame. To be included after `push`, which has `verdicts`.
#ifndef PARHELION_RECONSTRUCTION_VERDICTS_GLSL
#define PARHELION_RECONSTRUCTION_VERDICTS_GLSL

// The verdicts of the tiles around on the two signals.
struct Change {
    vec2 worth, drift;
};
Change find_change(uvec2 size, vec2 before_px) {
    const ivec2 last = (ivec2(size) + int(kChangeTile) - 1) / int(kChangeTile) - 1;
    const vec2 place = before_px / float(kChangeTile) - 0.5, f = fract(place);
    Change sum = Change(vec2(0.0), vec2(0.0));
    for (int i = 0; i < 4; ++i) {
        const ivec2 step = ivec2(i & 1, i >> 1), at = clamp(ivec2(floor(place)) + step, ivec2(0), last);
        const vec2 weights = mix(1.0 - f, f, vec2(step));
        const float weight = weights.x * weights.y;
        const ChangeVerdict there = push.verdicts.v[at.y * (last.x + 1) + at.x];
        sum.worth += weight * unpackHalf2x16(there.worth);
        sum.drift += weight * unpackHalf2x16(there.drift);
    }
    return sum;
}
#endif
