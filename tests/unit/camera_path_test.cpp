// Camera paths: what they say at a moment, and what is wrong with a file.
#include "scene/camera_path.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace parhelion::camera_path_test {
namespace {

constexpr std::string_view kPath = R"({"schema": 1, "keys": [
    {"time": 1, "look_from": [0, 1, 4], "look_at": [0, 1, 0], "fov": 40},
    {"time": 3, "look_from": [2, 1, 4], "look_at": [0, 2, 0], "fov": 60},
    {"time": 4, "look_from": [2, 1, 8], "look_at": [0, 2, 0], "fov": 60}]})";

std::string error_of(std::string_view text, double seconds = 0.0) {
    try {
        parse_camera_path(text, "p.json").view_at(seconds);
    } catch (const Error& error) {
        EXPECT_EQ(error.line.find('\n'), std::string::npos);
        return error.line;
    }
    return "(accepted)";
}

TEST(CameraPath, goes_evenly_from_key_to_key_and_stands_before_and_after) {
    const CameraPath path = parse_camera_path(kPath, "p.json");
    EXPECT_EQ(path.view_at(0.0).position, glm::vec3(0, 1, 4));
    EXPECT_EQ(path.view_at(1.0).position, glm::vec3(0, 1, 4));
    EXPECT_EQ(path.view_at(2.0).position, glm::vec3(1, 1, 4));
    EXPECT_EQ(path.view_at(3.5).position, glm::vec3(2, 1, 6));
    EXPECT_EQ(path.view_at(9.0).position, glm::vec3(2, 1, 8));
    EXPECT_FLOAT_EQ(path.view_at(1.5).yfov, glm::radians(45.0f));
    const glm::vec3 towards = glm::normalize(glm::vec3(0, 1.5f, 0) - glm::vec3(1, 1, 4));
    EXPECT_LT(glm::length(path.view_at(2.0).forward - towards), 1e-6f);
}

TEST(CameraPath, one_key_is_a_camera_and_an_angle_may_be_left_out) {
    const CameraPath path = parse_camera_path(R"({"keys": [{"time": 0, "look_from": [0, 0, 1], "look_at": [0, 0, 0]}]})", "p.json");
    EXPECT_EQ(path.view_at(-5.0).position, glm::vec3(0, 0, 1));
    EXPECT_FLOAT_EQ(path.view_at(5.0).yfov, 0.8f);
}

TEST(CameraPath, what_is_wrong_with_a_file_is_one_clear_line) {
    const auto keys = [](std::string_view text) { return fmt::format(R"({{"keys": [{}]}})", text); };
    const std::pair<std::string, const char*> cases[] = {
        {"", "p.json: this is no camera path"},
        {"{", "p.json"},
        {"[1, 2]", "this is no camera path (its form is"},
        {"{}", "this is no camera path"},
        {R"({"keys": []})", "keys: is not a list of keys"},
        {R"({"keys": 3})", "keys: is not a list of keys"},
        {R"({"schema": 2, "keys": []})", "schema: this schema is unknown"},
        {keys("7"), "keys[0]"},
        {keys(R"({"look_from": [0, 0, 1], "look_at": [0, 0, 0]})"), "time"},
        {keys(R"({"time": "1", "look_from": [0, 0, 1], "look_at": [0, 0, 0]})"), "keys[0].time"},
        {keys(R"({"time": 0, "look_from": [0, 0], "look_at": [0, 0, 0]})"), "keys[0].look_from"},
        {keys(R"({"time": 0, "look_from": [0, 0, 1e30], "look_at": [0, 0, 0]})"), "beyond all measure"},
        {keys(R"({"time": 0, "look_from": [0, 0, 1], "look_at": [0, 0, 1]})"), "keys[0]: look_from and look_at are the same point"},
        {keys(R"({"time": 0, "look_from": [0, 0, 1], "look_at": [0, 0, 0], "fov": 180})"), "keys[0].fov: 180 is out of range (a number from 0.1 to 175)"},
        {keys(R"({"time": 0, "look_from": [0, 0, 1], "look_at": [0, 0, 0], "fow": 30})"), "1 of its members are unknown"},
        {keys(R"({"time": 1, "look_from": [0, 0, 1], "look_at": [0, 0, 0]}, {"time": 1, "look_from": [0, 0, 1], "look_at": [0, 0, 0]})"),
         "keys[1]: its time, 1 s, is not after that of the key before, 1 s"},
        {keys(R"({"time": 1, "look_from": [0, 0, 1], "look_at": [0, 0, 0], "fov": 30}, {"time": 2, "look_from": [0, 0, 1], "look_at": [0, 0, 0]})"),
         "keys[1]: lacks a fov, the first key has one"},
    };
    for (const auto& [text, expected] : cases) EXPECT_NE(error_of(text).find(expected), std::string::npos) << text << "\n" << error_of(text);
    const std::string crossing = keys(R"({"time": 0, "look_from": [0, 0, 1], "look_at": [0, 0, 0]}, {"time": 2, "look_from": [0, 0, -1], "look_at": [0, 0, 0]})");
    EXPECT_EQ(error_of(crossing, 0.5), "(accepted)");
    EXPECT_NE(error_of(crossing, 1.0).find("p.json: at 1 seconds the camera looks at the point where it stands"), std::string::npos) << error_of(crossing, 1.0);
    EXPECT_THROW(read_camera_path("/nowhere/path.json"), Error);
}

}  // namespace
}  // namespace parhelion::camera_path_test
