// The world cache as those see it who light a surface: the irradiance at a point that a path has reached, and the wish for a cell there.
//     if (cache_query(cache, point, irradiance)) ...      what is known
//     cache_insert(cache, point, life)                    a cell for the frames to come, or a longer life for the one that is there
//     cache_visit(cache, point, life, irradiance)         both, with one look at the table; cache_consult says too how much it is worth
// Within a frame nothing that a query reads changes: cells come in and claims gather beside it, and the passes of the next frame see to
// them (docs/world-cache.md). Irradiance is pre-exposed, over the hemisphere of the geometric normal.
#ifndef PARHELION_SCENE_CACHE_ASK_GLSL
#define PARHELION_SCENE_CACHE_ASK_GLSL
#include "scene/cache_table.glsl"
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_control_flow_attributes : require

// A point that asks. Every member is a function of the path alone.
struct CachePoint {
    vec3 position_ws;
    vec3 origin_ws;       // where a ray into the hemisphere starts (spawn_ray)
    vec3 n_geometric_ws;  // unit, on the side from where the path came
    vec3 back_ws;         // to where the path came from, metres
    uint owner;           // instance: things share no cells
    float footprint;      // metres, see cache_footprint
    float u;              // in [0, 1): dissolves levels, moves the look-up
};

// The footprint that a path asks with, metres: the width of its cone, but no cell is smaller than some pixels look there. `pixel_width`
// is that of a pixel over the whole way to the point, as if the path had gone straight on.
float cache_footprint(Cache cache, float cone_width, float pixel_width) { return max(cone_width, pixel_width * (cache.v.cell_pixels / cache.v.cell_scale)); }

uint cache_point_level(Cache cache, CachePoint at) { return cache_level(at.position_ws, cache_normal_code(at.n_geometric_ws), at.footprint * cache.v.cell_scale, at.u); }
// Whether no cell of a level is so long that it holds faces of two rooms which a wall divides: as far as the path saw nothing before it.
bool cache_in_room(CachePoint at, uint level) { return cache_level_size(level) <= kCacheFlat * dot(at.back_ws, at.n_geometric_ws); }
float cache_cell_size(Cache cache, CachePoint at) { return cache_level_size(cache_point_level(cache, at)); }

vec3 cache_jitter(Cache cache, float u) {
    const uint h = pcg_hash(floatBitsToUint(u) ^ 0x4A495454u);
    return (vec3(h & 1023u, (h >> 10) & 1023u, (h >> 20) & 1023u) * (1.0 / 1024.0) - 0.5) * cache.v.jitter;
}

// Where a point's cell of a level is kept, or would be.
struct CachePlace {
    uint64_t key;
    vec3 corner;
    uint level;
    uint bucket;
};
CachePlace cache_place(Cache cache, CachePoint at, uint level) {
    CachePlace place;
    place.level = min(level, kCacheLevels - 1u);
    const uint normal_code = cache_normal_code(at.n_geometric_ws);
    const ivec3 cell = cache_cell(at.position_ws, at.n_geometric_ws, normal_code, place.level, cache_jitter(cache, at.u));
    place.corner = cache_corner(cell, normal_code);
    place.key = cache_key(cell, place.level, normal_code, at.owner);
    place.bucket = cache_bucket(place.key, cache.v.bucket_mask);
    return place;
}

// The slot of a key. `newborn`: it came in this frame. The whole bucket is looked through: deleted cells leave holes anywhere. Eight at a
// time, so that one wait for memory does for all of them.
uint cache_find(Cache cache, CachePlace place, out bool newborn) {
    CacheWords64 keys = CacheWords64(cache.v.keys);
    newborn = false;
    [[unroll]] for (uint first = 0u; first < kCacheBucket; first += 8u) {
        uint64_t there[8];
        uint found = kCacheNoSlot;
        [[unroll]] for (uint i = 0u; i < 8u; ++i) there[i] = keys.v[cache_probe(place.key, place.bucket, first + i)];
        [[unroll]] for (uint i = 0u; i < 8u; ++i)
            if ((there[i] & ~kCacheNewborn) == place.key) {
                found = cache_probe(place.key, place.bucket, first + i);
                newborn = (there[i] & kCacheNewborn) != 0ul;
            }
        if (found != kCacheNoSlot) return found;
    }
    return kCacheNoSlot;
}

// How strictly a bucket lets cells in: twice as strictly since each overflow, half as much again after 16 frames without one. An overflow
// of this frame counts from the next one on, or who comes late would be judged otherwise.
uint cache_strictness(uint bucket, uint frame_index) {
    const uint since = frame_index - (bucket >> 8), strictness = bucket & 255u;
    if (bucket == 0u) return 0u;
    if (since == 0u) return strictness - 1u;
    return strictness - min(strictness, since / 16u);
}

// More cells came than the bucket has room for. Which of them found it depended on their order, so all that came in this frame go again
// (cache/maintain), and fewer are let in. Whether it happens depends only on how many came.
void cache_overflow(Cache cache, uint bucket, uint frame_index) {
    CacheWords buckets = CacheWords(cache.v.buckets);
    const uint before = buckets.v[bucket];
    if (before != 0u && before >> 8 == frame_index) return;
    atomicMax(buckets.v[bucket], frame_index << 8 | min(cache_strictness(before, frame_index) + 1u, 25u));
}

// The slot of a key that is not in the table: the first free one of its bucket, or who else brought it there meanwhile.
uint cache_take_slot(Cache cache, CachePlace place) {
    CacheWords64 keys = CacheWords64(cache.v.keys);
    const uint frame_index = cache.v.frame_index & 0xFFFFFFu;
    const uint64_t key = place.key | kCacheNewborn;
    if (!cache_admitted(place.key, cache_strictness(CacheWords(cache.v.buckets).v[place.bucket], frame_index))) {
        atomicAdd(cache.v.refused, 1u);
        return kCacheNoSlot;
    }
    for (uint i = 0u; i < kCacheBucket; ++i) {
        const uint slot = cache_probe(place.key, place.bucket, i);
        uint64_t there = keys.v[slot];
        if (there == kCacheNoKey) there = atomicCompSwap(keys.v[slot], kCacheNoKey, key);
        if (there == key) return slot;
        if (there != kCacheNoKey) continue;
        CacheWords(cache.v.lists[cache.v.list]).v[atomicAdd(cache.v.live, 1u)] = slot;
        return slot;
    }
    cache_overflow(cache, place.bucket, frame_index);
    atomicAdd(cache.v.refused, 1u);
    return kCacheNoSlot;
}

void cache_claim_slot(Cache cache, uint slot, uint64_t point, uint life) {
    CacheWords64 claims = CacheWords64(cache.v.claims);
    const uint64_t claim = cache_claim(life, point, cache_salt(cache.v.frame_index));
    if (claim < claims.v[slot]) atomicMin(claims.v[slot], claim);
}

// count 0: nothing is known.
struct CacheAnswer {
    vec3 irradiance;
    float count;  // what it is worth, in samples
    uint slot;    // of the cell at the point itself, or kCacheNoSlot
};
CacheAnswer cache_read(Cache cache, uint slot) {
    const CacheMoments moments = cache_unpack_moments(CacheWords(cache.v.moments).v[slot]);
    return CacheAnswer(cache_unpack_irradiance(CacheWords64(cache.v.irradiance).v[slot]), cache_worth(moments.count), slot);
}

// Whether a point asks for a cell of a level above its own too: one in four that a pixel's path reached. Paths of the update go on where
// they find nothing; did they ask too, cells of one level would call for the next one's without end.
bool cache_wants_parent(Cache cache, CachePoint at, uint life, uint above) {
    if (above == 0u) return true;
    const uint h = pcg_hash(floatBitsToUint(at.u) ^ 0x50415245u);
    return life >= cache.v.life && (h & ((1u << (2u * above)) - 1u)) == 0u;
}

// Asks, and with a life above 0 claims. A cell with few samples is helped out by those above it.
CacheAnswer cache_consult(Cache cache, CachePoint at, uint life) {
    const uint level = cache_point_level(cache, at);
    float missing = 1.0;
    CacheAnswer sum = CacheAnswer(vec3(0.0), 0.0, kCacheNoSlot);
    for (uint above = 0u; above <= kCacheParents && level + above < kCacheLevels; ++above) {
        if (above != 0u && !cache_in_room(at, level + above)) break;
        const bool claims = life != 0u && cache_wants_parent(cache, at, life, above);
        if (!claims && missing <= 0.0) continue;
        const CachePlace place = cache_place(cache, at, level + above);
        bool newborn;
        uint slot = cache_find(cache, place, newborn);
        if (slot != kCacheNoSlot && !newborn && missing > 0.0) {
            if (above == 0u) sum.slot = slot;
            const CacheAnswer answer = cache_read(cache, slot);
            const float share = missing * min(answer.count / float(kCacheYoung), 1.0);
            sum.irradiance += share * answer.irradiance;
            sum.count += share * answer.count;
            missing -= share;
        }
        if (!claims) continue;
        const uint64_t point = cache_pack_point(at.origin_ws, at.n_geometric_ws, at.back_ws, place.corner, place.level);
        if (point == kCacheNoPoint) continue;
        if (slot == kCacheNoSlot) slot = cache_take_slot(cache, place);
        if (slot != kCacheNoSlot) cache_claim_slot(cache, slot, point, life);
    }
    if (missing < 1.0) sum.irradiance /= 1.0 - missing;
    return sum;
}

bool cache_visit(Cache cache, CachePoint at, uint life, out vec3 irradiance) {
    const CacheAnswer answer = cache_consult(cache, at, life);
    irradiance = answer.irradiance;
    return answer.count > 0.0;
}

// False: nothing is known there, and the caller goes on with its path.
bool cache_query(Cache cache, CachePoint at, out vec3 irradiance) { return cache_visit(cache, at, 0u, irradiance); }

// `life`: cache.v.life for paths from pixels; for those from cells, what that cell has left.
void cache_insert(Cache cache, CachePoint at, uint life) {
    vec3 ignored;
    cache_visit(cache, at, life, ignored);
}

// What there is to see of the cell at a point, without touching it.
struct CacheView {
    uint id;     // hash of its key, for colours; 0: there is no cell
    uint level;  // of the point, whether it has a cell or not
    uint count, age, life;
    vec3 irradiance;
};
CacheView cache_look(Cache cache, CachePoint at) {
    CacheView view = CacheView(0u, cache_point_level(cache, at), 0u, 0u, 0u, vec3(0.0));
    const CachePlace place = cache_place(cache, at, view.level);
    bool newborn;
    const uint slot = cache_find(cache, place, newborn);
    if (slot == kCacheNoSlot || newborn) return view;
    const CacheMoments moments = cache_unpack_moments(CacheWords(cache.v.moments).v[slot]);
    view.id = max(uint(place.key), 1u);
    view.count = moments.count < 2u ? moments.count : moments.count - 1u;
    view.age = moments.age;
    view.life = cache_claim_life(CacheWords64(cache.v.claims).v[slot]);
    view.irradiance = cache_unpack_irradiance(CacheWords64(cache.v.irradiance).v[slot]);
    return view;
}
#endif
