#include "scene/animation.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "base/error.h"

namespace parhelion {

namespace {

// Key k's value; of a cubic spline the middle of its three parts (in-tangent, value, out-tangent).
const float* key_value(const AnimationChannel& c, size_t k) {
    return c.values.data() + (c.interpolation == Interpolation::CubicSpline ? 3 * k + 1 : k) * c.width;
}

void normalize_rotation(std::span<float> q) {
    double square = 0.0;
    for (const float x : q) square += double(x) * x;
    if (!(square > 0.0)) {
        std::fill(q.begin(), q.end(), 0.0f);
        q.back() = 1.0f;
        return;
    }
    for (float& x : q) x = static_cast<float>(x / std::sqrt(square));
}

// Appendix C.4: along the shorter of the two arcs; the quaternions need not be quite unit.
void slerp(const float* from, const float* to, double t, std::span<float> out) {
    glm::dvec4 a(from[0], from[1], from[2], from[3]), b(to[0], to[1], to[2], to[3]);
    const double lengths = glm::length(a) * glm::length(b);
    double cosine = lengths > 0.0 ? glm::dot(a, b) / lengths : 1.0;
    if (cosine < 0.0) b = -b, cosine = -cosine;
    const double angle = std::acos(std::min(cosine, 1.0));
    double wa = 1.0 - t, wb = t;
    if (angle > 1e-6) wa = std::sin(wa * angle) / std::sin(angle), wb = std::sin(wb * angle) / std::sin(angle);
    const glm::dvec4 q = wa * a + wb * b;
    for (glm::length_t i = 0; i < 4; ++i) out[static_cast<size_t>(i)] = static_cast<float>(q[i]);
}

// Appendix C.5, between keys k and k + 1 that are `span` seconds apart.
void hermite(const AnimationChannel& c, size_t k, double t, double span, std::span<float> out) {
    const float *v0 = key_value(c, k), *v1 = key_value(c, k + 1);
    const float *leaving = v0 + c.width, *arriving = v1 - c.width;
    const double t2 = t * t, t3 = t2 * t;
    for (size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<float>((2.0 * t3 - 3.0 * t2 + 1.0) * v0[i] + span * (t3 - 2.0 * t2 + t) * leaving[i] +
                                    (3.0 * t2 - 2.0 * t3) * v1[i] + span * (t3 - t2) * arriving[i]);
}

std::string animation_list(const Scene& scene) {
    std::string out;
    for (const auto& [handle, animation] : scene.animations())
        out += (out.empty() ? "" : ", ") + (animation.name.empty() ? "(no name)" : escape_name(animation.name, 60));
    return out.empty() ? "the scene has no animations" : "the animations are, from 0 on: " + out;
}

}  // namespace

void sample_channel(const AnimationChannel& c, double seconds, std::span<float> out) {
    PARHELION_CHECK(out.size() == c.width, "{} numbers for a channel of {}", out.size(), c.width);
    const bool rotation = c.path == AnimatedPath::Rotation && c.width == 4;
    size_t k = 0;
    if (seconds > c.times.front())
        k = static_cast<size_t>(std::upper_bound(c.times.begin(), c.times.end(), seconds, [](double s, float key) { return s < key; }) -
                                c.times.begin()) - 1;
    const bool between = seconds > c.times[k] && k + 1 < c.times.size();
    if (!between || c.interpolation == Interpolation::Step) {
        std::copy_n(key_value(c, k), c.width, out.begin());
    } else {
        const double span = double(c.times[k + 1]) - c.times[k], t = (seconds - c.times[k]) / span;
        const float *v0 = key_value(c, k), *v1 = key_value(c, k + 1);
        if (c.interpolation == Interpolation::CubicSpline)
            hermite(c, k, t, span, out);
        else if (rotation)
            slerp(v0, v1, t, out);
        else
            for (size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>((1.0 - t) * v0[i] + t * v1[i]);
    }
    if (rotation) normalize_rotation(out);
}

uint32_t moved_slot(const AnimationChannel& c) {
    switch (object_of(c.path)) {
        case AnimatedObject::Light:
            return c.light.index;
        case AnimatedObject::Camera:
            return c.camera.index;
        case AnimatedObject::Node:
            break;
    }
    return c.node.index;
}

std::vector<Handle<Animation>> choose_animations(const Scene& scene, std::string_view wanted) {
    std::vector<Handle<Animation>> all;
    for (const auto& [handle, animation] : scene.animations()) {
        if (!wanted.empty() && animation.name == wanted) return {handle};
        all.push_back(handle);
    }
    if (!wanted.empty()) {
        size_t index = 0;
        const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
        if (error == std::errc{} && end == wanted.data() + wanted.size() && index < all.size()) return {all[index]};
        throw Error(ErrorCode::Usage, fmt::format("there is no animation '{}'", escape_name(wanted)), "--animation", animation_list(scene));
    }
    std::set<std::pair<uint32_t, AnimatedPath>> moved;
    std::erase_if(all, [&](Handle<Animation> handle) {
        const std::vector<AnimationChannel>& channels = scene.get(handle).channels;
        for (const AnimationChannel& c : channels)
            if (moved.contains({moved_slot(c), c.path})) return true;
        for (const AnimationChannel& c : channels) moved.insert({moved_slot(c), c.path});
        return false;
    });
    return all;
}

float duration_of(const Animation& animation) {
    float end = 0.0f;
    for (const AnimationChannel& c : animation.channels) end = std::max(end, c.times.back());
    return end;
}

}  // namespace parhelion
