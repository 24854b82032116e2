#include "scene/camera_path.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/file.h"
#include "scene/gltf/json.h"

namespace parhelion {

namespace {

constexpr std::string_view kForm = R"({"keys": [{"time": 0, "look_from": [x, y, z], "look_at": [x, y, z], "fov": 40}, ...]})";

glm::dvec3 read_point(const JsonRef& key, std::string_view name) {
    const JsonRef value = key.at(name);
    value.require_numbers(3);
    glm::dvec3 point;
    for (int i = 0; i < 3; ++i) {
        point[i] = value[static_cast<size_t>(i)].as_number();
        if (std::abs(point[i]) > kLargestCoordinate) value.fail(fmt::format("{} is beyond all measure", point[i]), "metres");
    }
    return point;
}

double read_between(const JsonRef& value, double min, double max) {
    const double number = value.as_number();
    if (number < min || number > max) value.fail(fmt::format("{} is out of range", number), fmt::format("a number from {} to {}", min, max));
    return number;
}

CameraKey read_key(const JsonRef& json) {
    constexpr double kDegree = 3.14159265358979323846 / 180.0;
    CameraKey key;
    key.time = read_between(json.at("time"), -1e6, 1e6);
    key.look_from = read_point(json, "look_from");
    key.look_at = read_point(json, "look_at");
    if (key.look_from == key.look_at) json.fail("look_from and look_at are the same point", "choose two different points");
    if (const auto fov = json.find("fov")) key.yfov = read_between(*fov, 0.1, 175.0) * kDegree;
    return key;
}

}  // namespace

CameraView CameraPath::view_at(double seconds) const {
    const auto next = std::upper_bound(keys.begin(), keys.end(), seconds, [](double s, const CameraKey& key) { return s < key.time; });
    CameraKey now = next == keys.begin() ? keys.front() : *(next - 1);
    if (next != keys.begin() && next != keys.end()) {
        const double share = (seconds - now.time) / (next->time - now.time);
        now.look_from = glm::mix(now.look_from, next->look_from, share);
        now.look_at = glm::mix(now.look_at, next->look_at, share);
        now.yfov = glm::mix(now.yfov, next->yfov, share);
    }
    if (glm::vec3(now.look_from) == glm::vec3(now.look_at))
        throw Error(ErrorCode::Failed, fmt::format("at {} seconds the camera looks at the point where it stands", seconds), file,
                    "keep look_at apart from look_from between the keys too");
    return look_at(glm::vec3(now.look_from), glm::vec3(now.look_at), static_cast<float>(now.yfov));
}

CameraPath parse_camera_path(std::string_view text, std::string name) {
    if (const size_t begin = text.find_first_not_of(" \t\r\n"); begin == std::string_view::npos || text[begin] != '{')
        throw Error(ErrorCode::Failed, "this is no camera path", name, "its form is " + std::string(kForm));
    const JsonDocument document(text, name, {.max_bytes = 64 << 20, .max_depth = 8});
    const JsonRef root = document.root();
    if (!root.find("keys")) root.fail("this is no camera path", "its form is " + std::string(kForm));
    if (const auto schema = root.find("schema"); schema && schema->as_uint(1000) != 1) schema->fail("this schema is unknown", "it is 1");
    const JsonRef keys = root.at("keys");
    if (!keys.is_array() || keys.size() == 0) keys.fail("is not a list of keys", "its form is " + std::string(kForm));
    CameraPath path{.file = std::move(name)};
    for (size_t i = 0; i < keys.size(); ++i) {
        const CameraKey key = read_key(keys[i]);
        if (i > 0 && !(key.time > path.keys.back().time))
            keys[i].fail(fmt::format("its time, {} s, is not after that of the key before, {} s", key.time, path.keys.back().time), "sort the keys by time");
        path.keys.push_back(key);
    }
    // What else is in the file has been mistyped.
    uint64_t known = root.find("schema") ? 2 : 1;
    for (size_t i = 0; i < keys.size(); ++i) known += keys[i].find("fov") ? 4 : 3;
    if (document.shape().keys != known)
        root.fail(fmt::format("{} of its members are unknown", document.shape().keys - known), "its form is " + std::string(kForm));
    const auto has_fov = [&](size_t i) { return keys[i].find("fov").has_value(); };
    for (size_t i = 1; i < keys.size(); ++i)
        if (has_fov(i) != has_fov(0)) keys[i].fail(fmt::format("{} a fov, the first key {}", has_fov(i) ? "has" : "lacks", has_fov(0) ? "has one" : "has none"), "give every key one, or none");
    return path;
}

CameraPath read_camera_path(const std::filesystem::path& file) {
    constexpr uint64_t kMaxBytes = 64 << 20;
    return parse_camera_path(read_text_file(file, kMaxBytes), escape_name(file.string()));
}

}  // namespace parhelion
