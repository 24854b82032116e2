#pragma once
// Results: stdout and JSON. Everything that is not a result goes to stderr through base/log.h.
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "base/error.h"

namespace parhelion {

// Writes to stdout and makes sure that it arrived; throws Error (Failed) if it did not: a full disk, a closed pipe.
void print_result(std::string_view text);

// `target` is "" (nothing is written), "-" (stdout) or a file, which appears whole or not at all. The object gets "schema": 1.
void write_json(const std::string& target, const nlohmann::ordered_json& object);
// Throws unless write_json can write there; called before long work.
void check_json_target(const std::string& target);

nlohmann::ordered_json error_json(const Error& error);  // {"schema": 1, "error": {"code", "what", "where", "hint"}}

}  // namespace parhelion
