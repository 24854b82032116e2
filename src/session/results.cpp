#include "session/results.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <nlohmann/json.hpp>

#include "base/file.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

void print_result(std::string_view text) {
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
    if (!written || std::fflush(stdout) != 0)
        throw Error(ErrorCode::Failed, fmt::format("writing failed: {}", std::strerror(errno)), "stdout");
}

void write_json(const std::string& target, const Json& object) {
    if (target.empty()) return;
    Json whole = {{"schema", 1}};
    whole.update(object);
    // Names from files may be invalid UTF-8: such bytes become U+FFFD instead of a failure.
    const std::string text = whole.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    if (target == "-")
        print_result(text);
    else
        write_text_file(target, text);
}

void check_json_target(const std::string& target) {
    if (!target.empty() && target != "-") check_writable(target);
}

Json error_json(const Error& error) {
    return {{"schema", 1},
            {"error", {{"code", error_code_name(error.code)}, {"what", error.problem}, {"where", error.where}, {"hint", error.hint}}}};
}

}  // namespace parhelion
