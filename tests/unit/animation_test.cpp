// Sampling of animation channels (glTF 2.0, appendix C) by hand, and which animations play.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/animation.h"

namespace parhelion::animation_test {

namespace {

std::vector<float> sample(const AnimationChannel& channel, double seconds) {
    std::vector<float> out(channel.width);
    sample_channel(channel, seconds, out);
    return out;
}

AnimationChannel numbers(Interpolation interpolation, std::vector<float> values) {
    return {.path = AnimatedPath::Weights, .interpolation = interpolation, .width = 1, .times = {1, 2, 4}, .values = std::move(values)};
}

// A turn about z.
std::vector<float> turn(double degrees) {
    const double half = degrees * M_PI / 360.0;
    return {0.0f, 0.0f, float(std::sin(half)), float(std::cos(half))};
}

AnimationChannel rotations(const std::vector<float>& from, const std::vector<float>& to) {
    AnimationChannel channel{.path = AnimatedPath::Rotation, .width = 4, .times = {0, 1}, .values = from};
    channel.values.insert(channel.values.end(), to.begin(), to.end());
    return channel;
}

void expect_rotation(const std::vector<float>& q, const std::vector<float>& expected) {
    for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(q[i], expected[i], 1e-6f) << i;
}

struct TwoAnimations {
    Scene scene;
    TwoAnimations() {
        SceneEdit edit;
        const Handle<Node> a = edit.add(Node{}), b = edit.add(Node{});
        const auto channel = [](Handle<Node> node, AnimatedPath path) {
            return AnimationChannel{.node = node, .path = path, .times = {0.5f}, .values = {1, 1, 1}};
        };
        edit.add(Animation{.name = "walk", .channels = {channel(a, AnimatedPath::Translation), channel(b, AnimatedPath::Translation)}});
        edit.add(Animation{.name = "run", .channels = {channel(b, AnimatedPath::Translation), channel(b, AnimatedPath::Scale)}});
        edit.add(Animation{.name = "grow", .channels = {channel(b, AnimatedPath::Scale)}});
        scene.apply(std::move(edit));
    }
    std::vector<std::string> chosen(std::string_view wanted) const {
        std::vector<std::string> out;
        for (const Handle<Animation> handle : choose_animations(scene, wanted)) out.push_back(scene.get(handle).name);
        return out;
    }
};

}  // namespace

TEST(AnimationSampling, steps_hold_the_key_before) {
    const AnimationChannel c = numbers(Interpolation::Step, {10, 20, 30});
    for (const auto& [seconds, value] : {std::pair{1.0, 10.0f}, {1.999, 10.0f}, {2.0, 20.0f}, {3.9, 20.0f}, {4.0, 30.0f}})
        EXPECT_EQ(sample(c, seconds)[0], value) << seconds;
}

TEST(AnimationSampling, lines_meet_the_keys_and_divide_what_lies_between) {
    const AnimationChannel c = numbers(Interpolation::Linear, {10, 20, 30});
    for (const auto& [seconds, value] : {std::pair{1.0, 10.0f}, {1.25, 12.5f}, {2.0, 20.0f}, {3.5, 27.5f}, {4.0, 30.0f}})
        EXPECT_EQ(sample(c, seconds)[0], value) << seconds;
}

TEST(AnimationSampling, before_the_first_key_and_after_the_last_the_value_stands) {
    for (const Interpolation interpolation : {Interpolation::Step, Interpolation::Linear}) {
        EXPECT_EQ(sample(numbers(interpolation, {10, 20, 30}), 0.0)[0], 10.0f);
        EXPECT_EQ(sample(numbers(interpolation, {10, 20, 30}), 1e6)[0], 30.0f);
        EXPECT_EQ(sample(numbers(interpolation, {10, 20, 30}), std::nan(""))[0], 10.0f);
    }
    const AnimationChannel spline = numbers(Interpolation::CubicSpline, {9, 10, 9, 9, 20, 9, 9, 30, 9});
    EXPECT_EQ(sample(spline, 0.0)[0], 10.0f);
    EXPECT_EQ(sample(spline, 9.0)[0], 30.0f);
}

TEST(AnimationSampling, splines_follow_their_tangents_scaled_by_the_time_between_keys) {
    // Keys at 1, 2, 4 seconds: in-tangent, value, out-tangent.
    const AnimationChannel c = numbers(Interpolation::CubicSpline, {0, 0, 0, 0, 8, 4, 2, 0, 0});
    EXPECT_EQ(sample(c, 1.0)[0], 0.0f);
    EXPECT_FLOAT_EQ(sample(c, 1.5)[0], 4.0f);  // flat tangents: half way
    EXPECT_FLOAT_EQ(sample(c, 1.25)[0], 8.0f * 0.15625f);
    EXPECT_EQ(sample(c, 2.0)[0], 8.0f);
    // Half way: (v0 + v1) / 2 + span (out - in) / 8.
    EXPECT_FLOAT_EQ(sample(c, 3.0)[0], 4.0f + 2.0f * (4.0f - 2.0f) / 8.0f);
}

TEST(AnimationSampling, rotations_turn_evenly) {
    const AnimationChannel c = rotations(turn(0), turn(120));
    expect_rotation(sample(c, 0.25), turn(30));
    expect_rotation(sample(c, 0.5), turn(60));
    expect_rotation(sample(c, 1.0), turn(120));
}

TEST(AnimationSampling, rotations_take_the_shorter_way) {
    std::vector<float> other = turn(120);
    for (float& x : other) x = -x;  // the same rotation
    expect_rotation(sample(rotations(turn(0), other), 0.25), turn(30));
    // From 0 to 270 degrees the shorter way is backwards.
    expect_rotation(sample(rotations(turn(0), turn(270)), 1.0 / 3.0), turn(-30));
}

TEST(AnimationSampling, rotations_are_unit_whatever_the_keys) {
    AnimationChannel c = rotations({0, 0, 0, 2}, {0, 0, 3, 3});
    expect_rotation(sample(c, 0.0), turn(0));
    expect_rotation(sample(c, 0.0 + 1.0), turn(90));
    c.values = {0, 0, 0, 0, 0, 0, 0, 0};
    expect_rotation(sample(c, 0.5), turn(0));
    c.interpolation = Interpolation::CubicSpline;
    c.values = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
    expect_rotation(sample(c, 0.5), turn(90));  // (0, 0, 0.5, 0.5), made unit
}

TEST(AnimationChoice, without_a_name_animations_play_together_unless_they_move_the_same) {
    EXPECT_EQ(TwoAnimations().chosen(""), (std::vector<std::string>{"walk", "grow"}));
}

TEST(AnimationChoice, takes_a_name_or_a_number_and_lists_them_otherwise) {
    const TwoAnimations fixture;
    EXPECT_EQ(fixture.chosen("run"), std::vector<std::string>{"run"});
    EXPECT_EQ(fixture.chosen("2"), std::vector<std::string>{"grow"});
    for (const char* wrong : {"3", "Run", "-1", "1x"}) {
        try {
            fixture.chosen(wrong);
            FAIL() << wrong;
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Usage);
            EXPECT_NE(error.line.find("walk, run, grow"), std::string::npos) << error.line;
        }
    }
    EXPECT_THROW(choose_animations(Scene(), "walk"), Error);
    EXPECT_TRUE(choose_animations(Scene(), "").empty());
}

TEST(AnimationChoice, the_duration_is_that_of_the_last_key) {
    EXPECT_EQ(duration_of({.channels = {numbers(Interpolation::Step, {1, 2, 3}), rotations(turn(0), turn(1))}}), 4.0f);
    EXPECT_EQ(duration_of({}), 0.0f);
}

}  // namespace parhelion::animation_test
