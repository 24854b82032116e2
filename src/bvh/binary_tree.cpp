#include "bvh/binary_tree.h"

#include <bit>
#include <cmath>

#include "base/error.h"
#include "bvh/split.h"

namespace parhelion::bvh {

namespace {

constexpr uint32_t kSubtree = 1u << 12;   // ranges up to this size are one thread's work
constexpr uint32_t kTogether = 64;        // larger ranges are all threads' work, if they hold more than this part of everything
// Halves that have less in common are not worth a spatial split: shares of the root's surface (Stich et al. 2009) and of the range's
// own, if it is large or small.
constexpr float kSmallOverlap = 1e-5f, kShareLarge = 0.1f, kShareSmall = 0.3f;

struct Range {
    uint32_t first, count, slots;  // of the reference array; slots - count are free for spatial splits
    uint32_t depth;
    uint32_t* link;  // what refers to it
};

// What one thread, or all of them together, works with.
struct Worker {
    Team team;
    std::unique_ptr<Reference[]> scratch;
    size_t scratch_size = 0;
    Reference* scratch_of(size_t size) {
        if (size > scratch_size) {
            scratch.reset();
            scratch = std::make_unique_for_overwrite<Reference[]>(size);  // by the threads that fill it
            scratch_size = size;
        }
        return scratch.get();
    }
};

float overlap(const Box& a, const Box& b) {
    const glm::vec3 d = glm::min(a.max, b.max) - glm::max(a.min, b.min);
    return d.x < 0.0f || d.y < 0.0f || d.z < 0.0f ? 0.0f : d.x * d.y + d.y * d.z + d.z * d.x;
}

class Builder {
public:
    Builder(std::unique_ptr<Reference[]> references, uint32_t count, uint32_t slots, std::span<const shared::BvhTriangle> triangles, const BinaryLimits& limits)
        : triangles_(triangles), limits_(limits), count_(count) {
        tree_.references = std::move(references);
        tree_.nodes = std::make_unique_for_overwrite<BinaryNode[]>(slots);
        tree_.slots = slots;
    }

    BinaryTree build() {
        // Large ranges one after the other, each by all threads; then small ones side by side. A node's place is the first slot of
        // its second half, which no other node shares, so threads need no common counter.
        const uint32_t small = std::max(kSubtree, count_ / kTogether);
        std::vector<Range> large{{0, count_, tree_.slots, 0, &tree_.root}}, rest;
        Worker all{.team = {.all_threads = true}};
        while (!large.empty()) {
            const Range range = large.back();
            large.pop_back();
            if (range.count <= small) rest.push_back(range);
            else split_range(range, all, large), tree_.top.push_back(*range.link);
        }
        all.scratch.reset();
        std::stable_sort(rest.begin(), rest.end(), [](const Range& a, const Range& b) { return a.count > b.count; });
        parallel_for(rest.size(), 1, [&](size_t begin, size_t end) {
            Worker one;
            std::vector<Range> stack;
            for (size_t i = begin; i < end; ++i) {
                stack.push_back(rest[i]);
                while (!stack.empty()) {
                    const Range range = stack.back();
                    stack.pop_back();
                    split_range(range, one, stack);
                }
            }
        });
        for (const Range& range : rest) tree_.subtrees.push_back(*range.link);
        return std::move(tree_);
    }

private:
    std::span<Reference> references_of(const Range& range) { return {tree_.references.get() + range.first, range.count}; }

    // Makes the range's node, or refers to its only reference; pushes its halves.
    void split_range(const Range& range, Worker& worker, std::vector<Range>& out) {
        if (range.count <= 1) {
            *range.link = range.count == 1 ? shared::kBvhLeaf | range.first : shared::kBvhEmpty;
            return;
        }
        const std::span<Reference> references = references_of(range);
        const Extent extent = worker.team.sum<Extent>(references, [](Extent& e, const Reference& r) { e.add(Lanes(r)); });
        if (range.depth == 0) small_overlap_ = kSmallOverlap * extent.box.half_area();
        const Halves halves = split(range, extent, worker);
        const uint32_t index = halves.right_first;
        BinaryNode& node = tree_.nodes[index];
        const Box box = extent.box.box();
        node.min = box.min, node.max = box.max;
        *range.link = index;
        out.push_back({range.first, halves.left_count, halves.left_slots, range.depth + 1, &node.left});
        out.push_back({halves.right_first, halves.right_count, halves.right_slots, range.depth + 1, &node.right});
    }

    struct Halves {
        uint32_t left_count, left_slots, right_first, right_count, right_slots;
    };

    // Levels that halving a range down to leaves takes.
    uint32_t halvings(uint32_t count) const { return static_cast<uint32_t>(std::bit_width((count - 1) / limits_.max_leaf)); }

    // Halving always fits into the levels that are left; another split is taken only if both of its parts still can be halved,
    // however many references are added to them.
    bool fits(const Range& range, uint32_t left_slots) const {
        return range.count <= limits_.max_leaf || halvings(std::max(left_slots, range.slots - left_slots)) < limits_.max_height - range.depth;
    }

    Halves split(const Range& range, const Extent& extent, Worker& worker) {
        const std::span<Reference> references = references_of(range);
        ObjectSplit object;
        const Binning binning(extent);
        const bool sweep = range.count <= kSweep;
        if (sweep) static_cast<Split&>(object) = best_sweep_split(references, extent.centers.box());
        else object = best_binned_split(references, binning, worker.team);

        // Within a leaf's size no references are added: the height counts from there.
        const float small = std::max(small_overlap_, (sweep ? kShareSmall : kShareLarge) * extent.box.half_area());
        if (range.slots > range.count && range.count > limits_.max_leaf && (object.axis < 0 || overlap(object.left, object.right) > small)) {
            const SpatialSplit spatial = best_spatial_split(references, triangles_, extent.box.box(), object.cost, worker.team);
            if (spatial.axis >= 0 && spatial.left_count + spatial.right_count <= range.slots) {
                const Halves halves = divide(range, worker, [&](const Reference& r) { return part_reference(r, triangles_, spatial); });
                if (halves.left_count > 0) return halves;
            }
        }
        if (object.axis >= 0) {
            const Halves halves = sweep ? divide_at(range, object.left_count) : divide(range, worker, [&](const Reference& r) {
                return binning.bin(r, object.axis) < object.bin ? Parts{.left = r.box(), .right = {}} : Parts{.left = {}, .right = r.box()};
            });
            if (halves.left_count > 0) return halves;
        }
        return halve(range, extent.centers.box());
    }

    struct Side {
        uint32_t count = 0;
        double weight = 0;  // surfaces: how much spatial splits may gain there
        void add(const Box& box) { ++count, weight += box.half_area(); }
        void add(const Side& side) { count += side.count, weight += side.weight; }
    };

    // How many of the free slots go to the first half.
    static uint32_t share(uint32_t free, const Side& left, const Side& right) {
        const double part = left.weight / (left.weight + right.weight);
        return part >= 0.0 && part <= 1.0 ? static_cast<uint32_t>(free * part) : free / 2;
    }

    // Moves every reference, or its parts, to its side, in order. Returns no left half, and changes nothing, if one is empty or the
    // halves do not fit into the levels that are left.
    template <class PartOf>
    Halves divide(const Range& range, Worker& worker, PartOf&& part_of) {
        struct Sides {
            Side left, right;
        };
        const std::span<Reference> references = references_of(range);
        Reference* const scratch = worker.scratch_of(2 * references.size());  // chunk by chunk: first halves, then as much space for second ones
        std::vector<Sides> chunks((references.size() + kChunk - 1) / kChunk);
        worker.team.for_each_chunk(references.size(), [&](size_t c, size_t first, size_t last) {
            Sides& sides = chunks[c];
            for (size_t i = first; i < last; ++i) {
                const Parts parts = part_of(references[i]);
                const uint32_t index = references[i].index;
                if (!parts.left.empty()) scratch[2 * first + sides.left.count] = {parts.left.min, index, parts.left.max, 0}, sides.left.add(parts.left);
                if (!parts.right.empty()) scratch[first + last + sides.right.count] = {parts.right.min, index, parts.right.max, 0}, sides.right.add(parts.right);
            }
        });
        Sides sum;
        for (const Sides& sides : chunks) sum.left.add(sides.left), sum.right.add(sides.right);
        if (sum.left.count == 0 || sum.right.count == 0 || sum.left.count + sum.right.count > range.slots) return {};
        const uint32_t left_slots = sum.left.count + share(range.slots - sum.left.count - sum.right.count, sum.left, sum.right);
        if (!fits(range, left_slots)) return {};
        std::vector<Sides> before(chunks.size());
        for (size_t c = 1; c < chunks.size(); ++c) {
            before[c].left.count = before[c - 1].left.count + chunks[c - 1].left.count;
            before[c].right.count = before[c - 1].right.count + chunks[c - 1].right.count;
        }
        Reference* const left = references.data();
        worker.team.for_each_chunk(references.size(), [&](size_t c, size_t first, size_t last) {
            std::copy_n(scratch + 2 * first, chunks[c].left.count, left + before[c].left.count);
            std::copy_n(scratch + first + last, chunks[c].right.count, left + left_slots + before[c].right.count);
        });
        return {sum.left.count, left_slots, range.first + left_slots, sum.right.count, range.slots - left_slots};
    }

    // The same for references that are in order already.
    Halves divide_at(const Range& range, uint32_t left_count) {
        const std::span<Reference> references = references_of(range);
        Side left, right;
        for (uint32_t i = 0; i < range.count; ++i) (i < left_count ? left : right).add(references[i].box());
        const uint32_t left_slots = left_count + share(range.slots - range.count, left, right);
        if (!fits(range, left_slots)) return {};
        std::copy_backward(references.begin() + left_count, references.end(), references.end() + (left_slots - left_count));
        return {left_count, left_slots, range.first + left_slots, range.count - left_count, range.slots - left_slots};
    }

    // Equal numbers on both sides of the widest axis of the centers; the given order decides between equal centers. Gives up the free
    // slots.
    Halves halve(const Range& range, const Box& centers) {
        const glm::vec3 extent = centers.max - centers.min;
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const std::span<Reference> references = references_of(range);
        const uint32_t left_count = range.count / 2;
        std::nth_element(references.begin(), references.begin() + left_count, references.end(), [&](const Reference& a, const Reference& b) {
            const float x = center(a)[axis], y = center(b)[axis];
            return x != y ? x < y : a.index < b.index;
        });
        return {left_count, left_count, range.first + left_count, range.count - left_count, range.count - left_count};
    }

    const std::span<const shared::BvhTriangle> triangles_;
    const BinaryLimits limits_;
    const uint32_t count_;
    float small_overlap_ = 0;
    BinaryTree tree_;
};

}  // namespace

BinaryTree build_binary_tree(std::unique_ptr<Reference[]> references, uint32_t count, uint32_t slots, std::span<const shared::BvhTriangle> triangles, const BinaryLimits& limits) {
    const uint64_t most = uint64_t(limits.max_leaf) << limits.max_height;
    PARHELION_CHECK(std::has_single_bit(limits.max_leaf) && count <= slots && count <= most, "{} items do not fit into {} levels of leaves of {}", count, limits.max_height,
                    limits.max_leaf);
    return Builder(std::move(references), count, static_cast<uint32_t>(std::min<uint64_t>(slots, most)), triangles, limits).build();
}

}  // namespace parhelion::bvh
