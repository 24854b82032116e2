#version 460
// How fast light drifts away from the histories, by the last frame's tiles, and how many frames histories are worth then: one that is r a frame off
// is r N behind after N frames, and its noise is s / sqrt(N), of which the spatial filter leaves 1 / sqrt(K): the sum of the squares is least at
// N^3 = s^2 / (2 K r^2). A light that is switched is a fast drift. A drift counts by what it is larger than noise may make it, over 3 by 3,
// 5 by 5 and 9 by 9 tiles, of which the fastest is taken.
// Reads: tiles. Writes: verdicts.
#extension GL_GOOGLE_include_directive : require
#include "shared/reconstruction.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Tiles { ChangeTile v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Verdicts { ChangeVerdict v[]; };
layout(push_constant, scalar) uniform Push {
    Tiles tiles;
    Verdicts verdicts;
    uvec2 size;     // in tiles
    float antilag;  // ReconstructionFrame::antilag
    float history;  // frames at most
} push;

const float kFiltered = 3000.0;  // K: lag covers whole surfaces and is seen before noise
const int kFarthest = 4;         // tiles

ChangeSums add(ChangeSums a, ChangeSums b) { return ChangeSums(a.variance + b.variance, a.drift_now + b.drift_now, a.drift + b.drift, a.drift_variance + max(b.shared_noise, 1.0) * b.drift_variance, 0.0); }

void add(inout ChangeTile sum, ChangeTile t) { sum = ChangeTile(add(sum.diffuse, t.diffuse), add(sum.specular, t.specular), sum.count + t.count); }

// By the last frames, and by one alone, which must stand out by more.
float worth(ChangeSums sum, float count) {
    const float sure = push.antilag * push.antilag, sure_now = 2.8 * sure, running = kDriftShare / (2.0 - kDriftShare);
    const float drift = max(sum.drift * sum.drift - sure * running * sum.drift_variance, sum.drift_now * sum.drift_now - sure_now * sum.drift_variance) / count;  // squares, times `count`
    return drift <= 0.0 ? push.history : clamp(pow(sum.variance / (2.0 * kFiltered * drift), 1.0 / 3.0), 1.0, push.history);
}

void weigh(inout vec2 frames, ChangeTile sum) {
    if (sum.count >= 16.0) frames = min(frames, vec2(worth(sum.diffuse, sum.count), worth(sum.specular, sum.count)));
}

void main() {
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= push.size.x || id.y >= push.size.y) return;
    const uint tile = id.y * push.size.x + id.x;
    const ChangeSums kNone = ChangeSums(0.0, 0.0, 0.0, 0.0, 0.0);
    ChangeTile near = ChangeTile(kNone, kNone, 0.0), around = near, far = near;  // 3 by 3, 5 by 5, 9 by 9
    for (int y = -kFarthest; y <= kFarthest; ++y)
        for (int x = -kFarthest; x <= kFarthest; ++x) {
            const ivec2 at = ivec2(id) + ivec2(x, y);
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(push.size)))) continue;
            const ChangeTile t = push.tiles.v[uint(at.y) * push.size.x + uint(at.x)];
            const int distance = max(abs(x), abs(y));
            if (t.count == 0.0) continue;
            add(far, t);
            if (distance <= 2) add(around, t);
            if (distance <= 1) add(near, t);
        }
    vec2 frames = vec2(push.history);
    if (push.antilag > 0.0) {
        weigh(frames, near);
        weigh(frames, around);
        weigh(frames, far);
    }
    const ChangeTile own = push.tiles.v[tile];
    push.verdicts.v[tile] = ChangeVerdict(packHalf2x16(frames), packHalf2x16(vec2(own.diffuse.drift, own.specular.drift) / max(own.count, 1.0)),
                                          packHalf2x16(vec2(own.diffuse.shared_noise, own.specular.shared_noise)));
}
