#pragma once
// Typed, checked access to the JSON of a glTF file. Every value knows its place ("meshes[3].primitives[0].attributes.POSITION"),
// and every read says what it expects; what does not fit is an Error with file, place and expectation.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>
#include <nlohmann/json_fwd.hpp>

namespace parhelion {

struct JsonLimits {
    uint64_t max_bytes = 512ull << 20;
    uint32_t max_depth = 64;
    uint64_t max_values = 1ull << 32;  // each takes up to kBytesPerValue once parsed
    static constexpr uint64_t kBytesPerValue = 128;
};

// What a text would become, counted without parsing it.
struct JsonShape {
    uint32_t depth = 0;   // of nested arrays and objects
    uint64_t values = 0;  // upper bound on the number of values
    uint64_t keys = 0;    // of valid JSON: members of all objects, those that come twice too
};
JsonShape measure_json(std::string_view text);

class JsonRef;

// The parsed text. Refuses text that is too long or nested too deeply before parsing it.
class JsonDocument {
public:
    JsonDocument(std::string_view text, std::string file_name, const JsonLimits& limits = {});
    ~JsonDocument();
    JsonDocument(const JsonDocument&) = delete;
    JsonDocument& operator=(const JsonDocument&) = delete;
    JsonRef root() const;
    const std::string& file_name() const { return file_name_; }
    const JsonShape& shape() const { return shape_; }

private:
    std::string file_name_;
    JsonShape shape_;
    std::unique_ptr<nlohmann::json> json_;
};

// A value in a document; valid as long as the document is. Cheap to copy.
class JsonRef {
public:
    std::string path() const;   // "" for the root
    std::string where() const;  // file and path, as errors show it
    [[noreturn]] void fail(std::string what, std::string hint = {}) const;

    bool is_object() const;
    bool is_array() const;
    bool is_number() const;
    bool is_string() const;

    // Members of an object. at() fails if it is not there. Keys must outlive the reference (literals).
    std::optional<JsonRef> find(std::string_view key) const;
    JsonRef at(std::string_view key) const;
    std::optional<JsonRef> extension(std::string_view name) const;  // extensions.name

    // Arrays.
    size_t size() const;
    JsonRef operator[](size_t index) const;
    // The array `key`, empty if it is not there.
    std::optional<JsonRef> find_array(std::string_view key) const;
    size_t array_size(std::string_view key) const;

    // The value itself.
    double as_number() const;              // finite
    uint64_t as_uint(uint64_t max) const;  // a whole number in [0, max]; 3.0 is 3
    bool as_bool() const;
    std::string_view as_string() const;
    // An index into the root's array `table`.
    uint32_t as_index_of(std::string_view table) const;

    // Members with defaults.
    float number(std::string_view key, float fallback) const;
    uint64_t uint(std::string_view key, uint64_t fallback, uint64_t max) const;
    bool boolean(std::string_view key, bool fallback) const;
    std::string string(std::string_view key, std::string_view fallback = {}) const;
    template <glm::length_t N>
    glm::vec<N, float> vec(std::string_view key, glm::vec<N, float> fallback) const {
        const std::optional<JsonRef> array = find(key);
        if (!array) return fallback;
        array->require_numbers(N);
        for (glm::length_t i = 0; i < N; ++i) fallback[i] = (*array)[static_cast<size_t>(i)].as_float();
        return fallback;
    }
    float as_float() const;                    // finite as a float too
    void require_numbers(size_t count) const;  // an array of `count`

private:
    friend class JsonDocument;
    struct Step {
        const char* key;  // none: `index` counts
        size_t index;     // of an element, or the length of the key
    };
    JsonRef(const JsonDocument* document, const nlohmann::json* value) : document_(document), value_(value) {}
    JsonRef child(const nlohmann::json* value, Step step) const;
    [[noreturn]] void fail_type(std::string_view expected) const;

    static constexpr size_t kMaxSteps = 12;
    const JsonDocument* document_;
    const nlohmann::json* value_;
    // Only the first step_count_ are set and copied: references are made by the million.
    struct Steps {
        Steps() {}
        Steps(const Steps& other) : count(other.count) { std::copy_n(other.list, count, list); }
        Steps& operator=(const Steps& other) {
            count = other.count;
            std::copy_n(other.list, count, list);
            return *this;
        }
        size_t count = 0;
        Step list[kMaxSteps];
    } steps_;
};

}  // namespace parhelion
