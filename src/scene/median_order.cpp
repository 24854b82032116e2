#include "scene/median_order.h"

#include <algorithm>

#include "base/parallel.h"

namespace parhelion {

namespace {

struct Item {
    glm::vec3 centroid;  // times three
    uint32_t triangle;
};

// Below this many triangles the order inside matters little.
constexpr size_t kLeafSize = 2;

// Splits [begin, end) at its middle by the median along the longest axis; returns the middle.
Item* split(Item* begin, Item* end) {
    Bounds box;
    for (const Item* item = begin; item != end; ++item) box.add(item->centroid);
    const glm::vec3 size = box.max - box.min;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    Item* middle = begin + (end - begin) / 2;
    // Equal centroids are told apart by their number: the result does not depend on the library's nth_element.
    std::nth_element(begin, middle, end, [axis](const Item& a, const Item& b) {
        const float x = a.centroid[axis], y = b.centroid[axis];
        return x < y || (x == y && a.triangle < b.triangle);
    });
    return middle;
}

void order(Item* begin, Item* end) {
    while (static_cast<size_t>(end - begin) > kLeafSize) {
        Item* middle = split(begin, end);
        order(begin, middle);
        begin = middle;
    }
    std::sort(begin, end, [](const Item& a, const Item& b) { return a.triangle < b.triangle; });
}

}  // namespace

void order_triangles_by_median(Primitive& primitive) {
    const size_t count = primitive.triangles.size();
    if (count <= kLeafSize) return;
    std::vector<Item> items(count);
    for (size_t i = 0; i < count; ++i) {
        const glm::uvec3 t = primitive.triangles[i];
        items[i] = {primitive.positions[t.x] + primitive.positions[t.y] + primitive.positions[t.z], static_cast<uint32_t>(i)};
    }
    // The first levels one after the other, then the pieces side by side.
    constexpr size_t kPiece = 1u << 16;
    std::vector<std::pair<size_t, size_t>> pieces{{0, count}};
    while (pieces.front().second - pieces.front().first > kPiece) {
        std::vector<std::pair<size_t, size_t>> halves;
        for (const auto& [begin, end] : pieces) {
            const size_t middle = static_cast<size_t>(split(items.data() + begin, items.data() + end) - items.data());
            halves.emplace_back(begin, middle);
            halves.emplace_back(middle, end);
        }
        pieces = std::move(halves);
    }
    parallel_for(pieces.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) order(items.data() + pieces[i].first, items.data() + pieces[i].second);
    });
    std::vector<glm::uvec3> ordered(count);
    for (size_t i = 0; i < count; ++i) ordered[i] = primitive.triangles[items[i].triangle];
    primitive.triangles = std::move(ordered);
}

}  // namespace parhelion
