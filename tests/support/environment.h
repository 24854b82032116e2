#pragma once
#include <cstdlib>
#include <optional>
#include <string>

namespace parhelion::testing {

// An environment variable for as long as a test runs; nullptr: unset.
class Environment {
public:
    Environment(const char* name, const char* value) : name_(name) {
        if (const char* old = std::getenv(name)) before_ = old;
        value ? setenv(name, value, 1) : unsetenv(name);
    }
    ~Environment() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

private:
    const char* name_;
    std::optional<std::string> before_;
};

}  // namespace parhelion::testing
