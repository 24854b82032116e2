// Colours as anti-aliasing compares them, neighbourhoods of them, and what a history is worth.
#ifndef PARHELION_RECONSTRUCTION_COMPARED_GLSL
#define PARHELION_RECONSTRUCTION_COMPARED_GLSL
#include "lib/color.glsl"

// Roots, which are about as far apart as they look, luminance apart from the rest (YCoCg; Malvar and Sullivan 2003).
vec3 to_compared(vec3 light) {
    const vec3 c = sqrt(light);
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * (c.r - c.b), -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}
vec3 from_compared(vec3 y) {
    const float t = y.x - y.z;
    const vec3 c = max(vec3(t + y.y, y.x + y.z, t - y.y), vec3(0.0));
    return c * c;
}

// Sums over compared colours.
struct Neighbourhood {
    vec3 sum, squares;
    float count;
};
const Neighbourhood kNoNeighbourhood = Neighbourhood(vec3(0.0), vec3(0.0), 0.0);
void add(inout Neighbourhood n, vec3 compared) {
    n.sum += compared;
    n.squares += compared * compared;
    n.count += 1.0;
}
// Root of the mean square of what they lie off this colour.
vec3 deviation_from(Neighbourhood n, vec3 middle) { return sqrt(max((n.squares - 2.0 * middle * n.sum) / n.count + middle * middle, vec3(0.0))); }

// How far two neighbourhoods' means lie apart, in sums of their deviations. Details that one of them lacks spread the other's colours by more
// than they move its mean; a change, or something else in its place, moves the mean and spreads nothing.
float difference(Neighbourhood a, Neighbourhood b, float same_share) {
    const vec3 mean_a = a.sum / a.count, mean_b = b.sum / b.count;
    return length(mean_a - mean_b) / (length(deviation_from(a, mean_a)) + length(deviation_from(b, mean_b)) + same_share * max(mean_a.x, 1e-3));
}

// Frames that a history is worth, for how many pairs of frames in a row (about) none has shown it, and whether it was of something that moved.
struct Worth {
    float frames, misses;
    bool moved;
};
// The frames in 127 steps of their root so that small ones stay apart, up or down by 16 random bits; above them the misses and the motion.
// Whole numbers up to 2047 are exact in half floats.
const float kMostMisses = 7.0;
float pack_worth(Worth w, float most_frames, uint random) {
    const float step = sqrt(clamp(w.frames / max(most_frames, 1e-6), 0.0, 1.0)) * 127.0;
    return min(floor(step + float(random & 0xFFFFu) / 65536.0), 127.0) + 128.0 * w.misses + (w.moved ? 1024.0 : 0.0);
}
Worth unpack_worth(float packed, float most_frames) {
    const uint bits = uint(packed);
    const float root = float(bits & 127u) / 127.0;
    return Worth(root * root * most_frames, float(bits >> 7 & 7u), bits >> 10 != 0u);
}
#endif
