#include "sampling/blue_noise.h"

#include <bit>
#include <cmath>

#include "base/error.h"
#include "lib/hash.glsl"

namespace parhelion::sampling {

namespace {

constexpr int kRadius = 8;         // pixels; the Gaussian is below 1e-6 beyond
constexpr double kDeviation = 1.5;  // pixels, as Ulichney advises
constexpr uint32_t kTileSeed = 1;

// Energy of each pixel, the sum of Gaussians around all pixels that are set, on a torus. Kept in integers: sums are exact in any
// order and the tile cannot depend on how a machine rounds. For each row the extreme pixels are remembered.
class EnergyMap {
public:
    EnergyMap(uint32_t size, uint32_t seed) : size_(size), energy_(size * size), set_(size * size, 0), rows_(size) {
        for (int dy = -kRadius; dy <= kRadius; ++dy)
            for (int dx = -kRadius; dx <= kRadius; ++dx)
                kernel_.push_back(static_cast<int64_t>(std::lround(std::exp(-(dx * dx + dy * dy) / (2 * kDeviation * kDeviation)) * 0x1p28)));
        // A little noise decides between equals, which would otherwise be taken in scan order.
        for (uint32_t i = 0; i < size * size; ++i) energy_[i] = shared::hash_combine(seed, i) >> 28;
        for (uint32_t y = 0; y < size; ++y) update_row(y);
    }

    bool is_set(uint32_t pixel) const { return set_[pixel] != 0; }
    void toggle(uint32_t pixel) {
        const int64_t sign = set_[pixel] ? -1 : 1;
        set_[pixel] ^= 1;
        const uint32_t px = pixel % size_, py = pixel / size_;
        const int64_t* weight = kernel_.data();
        for (int dy = -kRadius; dy <= kRadius; ++dy) {
            const uint32_t y = (py + static_cast<uint32_t>(dy)) & (size_ - 1);
            for (int dx = -kRadius; dx <= kRadius; ++dx) energy_[y * size_ + ((px + static_cast<uint32_t>(dx)) & (size_ - 1))] += sign * *weight++;
            update_row(y);
        }
    }
    // The set pixel of highest energy, the clear one of lowest.
    uint32_t tightest_cluster() const {
        uint32_t best = kNowhere;
        for (const Row& row : rows_)
            if (row.cluster != kNowhere && (best == kNowhere || energy_[row.cluster] > energy_[best])) best = row.cluster;
        return best;
    }
    uint32_t largest_void() const {
        uint32_t best = kNowhere;
        for (const Row& row : rows_)
            if (row.gap != kNowhere && (best == kNowhere || energy_[row.gap] < energy_[best])) best = row.gap;
        return best;
    }

private:
    static constexpr uint32_t kNowhere = 0xFFFFFFFFu;
    struct Row {
        uint32_t cluster = kNowhere, gap = kNowhere;
    };
    void update_row(uint32_t y) {
        Row row;
        for (uint32_t i = y * size_; i < (y + 1) * size_; ++i) {
            if (set_[i]) {
                if (row.cluster == kNowhere || energy_[i] > energy_[row.cluster]) row.cluster = i;
            } else if (row.gap == kNowhere || energy_[i] < energy_[row.gap]) {
                row.gap = i;
            }
        }
        rows_[y] = row;
    }

    uint32_t size_;
    std::vector<int64_t> energy_, kernel_;
    std::vector<uint8_t> set_;
    std::vector<Row> rows_;
};

// A tenth of the pixels, first at random, then moved from clusters to voids until none is better placed elsewhere.
uint32_t place_first_pixels(EnergyMap& map, uint32_t count, uint32_t seed) {
    const uint32_t wanted = count / 10;
    for (uint32_t placed = 0, draw = 0; placed < wanted; ++draw) {
        const uint32_t pixel = shared::hash_combine(~seed, draw) & (count - 1);
        if (map.is_set(pixel)) continue;
        map.toggle(pixel);
        ++placed;
    }
    while (true) {
        const uint32_t cluster = map.tightest_cluster();
        map.toggle(cluster);
        const uint32_t gap = map.largest_void();
        map.toggle(gap);
        if (gap == cluster) return wanted;
    }
}

}  // namespace

std::vector<uint16_t> make_blue_noise(uint32_t size, uint32_t seed) {
    PARHELION_CHECK(std::has_single_bit(size) && size >= 16 && size <= 256, "size {}", size);
    const uint32_t count = size * size;
    EnergyMap map(size, seed);
    const uint32_t first = place_first_pixels(map, count, seed);
    std::vector<uint16_t> ranks(count);

    // Ranks below the first pattern: its clusters taken away one by one.
    EnergyMap thinned = map;
    for (uint32_t rank = first; rank-- > 0;) {
        const uint32_t pixel = thinned.tightest_cluster();
        thinned.toggle(pixel);
        ranks[pixel] = static_cast<uint16_t>(rank);
    }
    // Above it: its voids filled. Past one half this is also Ulichney's third phase, the energies of set and of clear pixels
    // adding up to a constant.
    for (uint32_t rank = first; rank < count; ++rank) {
        const uint32_t pixel = map.largest_void();
        map.toggle(pixel);
        ranks[pixel] = static_cast<uint16_t>(rank);
    }
    return ranks;
}

const std::vector<uint32_t>& blue_noise_words() {
    static const std::vector<uint32_t> words = [] {
        const std::vector<uint16_t> ranks = make_blue_noise(shared::kBlueNoiseSize, kTileSeed);
        std::vector<uint32_t> packed(ranks.size() / 2);
        for (size_t i = 0; i < packed.size(); ++i) packed[i] = ranks[2 * i] | (static_cast<uint32_t>(ranks[2 * i + 1]) << 16);
        return packed;
    }();
    return words;
}

}  // namespace parhelion::sampling
