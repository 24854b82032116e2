#include "scene/gltf/json.h"

#include <cmath>
#include <set>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/error.h"

namespace parhelion {

JsonShape measure_json(std::string_view text) {
    JsonShape shape{.depth = 0, .values = 1};
    uint32_t depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            ++shape.values;
            shape.depth = std::max(shape.depth, ++depth);
        } else if (c == '}' || c == ']') {
            depth -= depth > 0 ? 1 : 0;
        } else if (c == ',') {
            ++shape.values;
        } else if (c == ':') {
            ++shape.keys;
        }
    }
    return shape;
}

namespace {

// Members of all objects; the nesting is limited.
uint64_t count_members(const nlohmann::json& value) {
    uint64_t count = value.is_object() ? value.size() : 0;
    if (value.is_structured())
        for (const nlohmann::json& child : value) count += count_members(child);
    return count;
}

// The first key that an object of the text names twice.
std::string find_repeated_key(std::string_view text) {
    std::vector<std::set<std::string>> objects;
    std::string repeated;
    [[maybe_unused]] const nlohmann::json again = nlohmann::json::parse(text, [&](int, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
        if (event == nlohmann::json::parse_event_t::object_start) objects.emplace_back();
        if (event == nlohmann::json::parse_event_t::object_end) objects.pop_back();
        if (event == nlohmann::json::parse_event_t::key && !objects.back().insert(parsed.get<std::string>()).second && repeated.empty())
            repeated = parsed.get<std::string>();
        return true;
    });
    return repeated;
}

}  // namespace

JsonDocument::JsonDocument(std::string_view text, std::string file_name, const JsonLimits& limits) : file_name_(std::move(file_name)) {
    const auto refuse = [&](std::string what, std::string hint) {
        throw Error(ErrorCode::Failed, std::move(what), file_name_, std::move(hint));
    };
    if (text.size() > limits.max_bytes)
        refuse(fmt::format("its JSON is {} bytes long; the limit is {}", text.size(), limits.max_bytes), "keep buffers in .bin or .glb");
    shape_ = measure_json(text);
    if (shape_.depth > limits.max_depth)
        refuse(fmt::format("its JSON is nested {} levels deep; the limit is {}", shape_.depth, limits.max_depth), "no glTF needs that");
    if (shape_.values > limits.max_values)
        refuse(fmt::format("its JSON holds {} values; the memory budget allows {}", shape_.values, limits.max_values), "split the scene");
    try {
        json_ = std::make_unique<nlohmann::json>(nlohmann::json::parse(text));
    } catch (const nlohmann::json::exception& error) {
        std::string_view message = error.what();
        if (const size_t end = message.find("] "); end != std::string_view::npos) message.remove_prefix(end + 2);
        refuse(fmt::format("is not valid JSON: {}", escape_name(message)), "");
    }
    // glTF 2.0, 2.7: keys must be unique. Readers that take the first and readers that take the last would show different scenes.
    if (count_members(*json_) != shape_.keys)
        refuse(fmt::format("an object in its JSON has the key '{}' twice", escape_name(find_repeated_key(text), 40)), "remove one");
    if (!json_->is_object()) refuse("its JSON is not an object", "a glTF file begins with '{'");
}

JsonDocument::~JsonDocument() = default;

JsonRef JsonDocument::root() const { return {this, json_.get()}; }

std::string JsonRef::path() const {
    std::string out;
    for (size_t i = 0; i < steps_.count; ++i) {
        const auto& [key, index] = steps_.list[i];
        if (key == nullptr)
            out += fmt::format("[{}]", index);
        else
            out += (out.empty() ? "" : ".") + std::string(key, index);
    }
    return out;
}

std::string JsonRef::where() const { return steps_.count == 0 ? document_->file_name() : document_->file_name() + ": " + path(); }

void JsonRef::fail(std::string what, std::string hint) const { throw Error(ErrorCode::Failed, std::move(what), where(), std::move(hint)); }

void JsonRef::fail_type(std::string_view expected) const {
    std::string shown = value_->is_structured() ? value_->type_name() : value_->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    fail(fmt::format("is {}, expected {}", escape_name(shown, 40), expected));
}

JsonRef JsonRef::child(const nlohmann::json* value, Step step) const {
    PARHELION_CHECK(steps_.count < kMaxSteps, "a JSON path with more than {} steps", kMaxSteps);
    JsonRef out = *this;
    out.value_ = value;
    out.steps_.list[out.steps_.count++] = step;
    return out;
}

bool JsonRef::is_object() const { return value_->is_object(); }
bool JsonRef::is_array() const { return value_->is_array(); }
bool JsonRef::is_number() const { return value_->is_number(); }
bool JsonRef::is_string() const { return value_->is_string(); }

std::optional<JsonRef> JsonRef::find(std::string_view key) const {
    if (!value_->is_object()) fail_type("an object");
    const auto found = value_->find(key);
    if (found == value_->end()) return std::nullopt;
    return child(&*found, {.key = key.data(), .index = key.size()});
}

JsonRef JsonRef::at(std::string_view key) const {
    if (std::optional<JsonRef> found = find(key)) return *found;
    fail(fmt::format("lacks '{}'", key));
}

std::optional<JsonRef> JsonRef::extension(std::string_view name) const {
    const std::optional<JsonRef> extensions = find("extensions");
    if (!extensions) return std::nullopt;
    std::optional<JsonRef> found = extensions->find(name);
    if (found && !found->is_object()) found->fail_type("an object");
    return found;
}

size_t JsonRef::size() const {
    if (!value_->is_array()) fail_type("an array");
    return value_->size();
}

JsonRef JsonRef::operator[](size_t index) const {
    if (index >= size()) fail(fmt::format("has {} elements, wanted number {}", size(), index));
    return child(&(*value_)[index], {.key = nullptr, .index = index});
}

std::optional<JsonRef> JsonRef::find_array(std::string_view key) const {
    std::optional<JsonRef> found = find(key);
    if (found && !found->is_array()) found->fail_type("an array");
    return found;
}

size_t JsonRef::array_size(std::string_view key) const {
    const std::optional<JsonRef> found = find_array(key);
    return found ? found->size() : 0;
}

double JsonRef::as_number() const {
    if (!value_->is_number()) fail_type("a number");
    return value_->get<double>();
}

float JsonRef::as_float() const {
    const float value = static_cast<float>(as_number());
    if (!std::isfinite(value)) fail_type("a number in the range of float");
    return value;
}

uint64_t JsonRef::as_uint(uint64_t max) const {
    const std::string expected = fmt::format("a whole number from 0 to {}", max);
    uint64_t value = 0;
    if (value_->is_number_unsigned()) {
        value = value_->get<uint64_t>();
    } else {
        const double number = value_->is_number() ? value_->get<double>() : -1.0;
        if (!(number >= 0.0 && number < 9007199254740992.0 && number == std::floor(number))) fail_type(expected);
        value = static_cast<uint64_t>(number);
    }
    if (value > max) fail_type(expected);
    return value;
}

bool JsonRef::as_bool() const {
    if (!value_->is_boolean()) fail_type("true or false");
    return value_->get<bool>();
}

std::string_view JsonRef::as_string() const {
    if (!value_->is_string()) fail_type("a string");
    return value_->get_ref<const std::string&>();
}

uint32_t JsonRef::as_index_of(std::string_view table) const {
    const size_t count = document_->root().array_size(table);
    const uint64_t index = as_uint(0xFFFFFFFFull);
    if (index >= count)
        fail(fmt::format("names {}[{}], but the file has {}", table, index, count == 0 ? "none" : fmt::format("only {}", count)));
    return static_cast<uint32_t>(index);
}

float JsonRef::number(std::string_view key, float fallback) const {
    const std::optional<JsonRef> found = find(key);
    return found ? found->as_float() : fallback;
}

uint64_t JsonRef::uint(std::string_view key, uint64_t fallback, uint64_t max) const {
    const std::optional<JsonRef> found = find(key);
    return found ? found->as_uint(max) : fallback;
}

bool JsonRef::boolean(std::string_view key, bool fallback) const {
    const std::optional<JsonRef> found = find(key);
    return found ? found->as_bool() : fallback;
}

std::string JsonRef::string(std::string_view key, std::string_view fallback) const {
    const std::optional<JsonRef> found = find(key);
    return std::string(found ? found->as_string() : fallback);
}

void JsonRef::require_numbers(size_t count) const {
    if (!value_->is_array() || value_->size() != count) fail_type(fmt::format("an array of {} numbers", count));
}

}  // namespace parhelion
