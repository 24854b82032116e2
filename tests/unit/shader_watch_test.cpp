// Shaders that change while a viewer shows a scene.
#include "session/shader_watch.h"

#include <thread>

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "support/process.h"

namespace parhelion::testing::shader_watch_test {
namespace {

const std::filesystem::path kBuilt = std::filesystem::path(PARHELION_BINARY_DIR) / "shaders/test_shaders/test_shaders.pack";

// Polls until something comes of it, for some seconds at most.
struct Polled {
    std::shared_ptr<const gpu::ShaderPack> pack;
    std::string error;
};
Polled poll(ShaderWatch& watch) {
    for (int i = 0; i < 2000; ++i) {
        try {
            if (auto pack = watch.poll()) return {pack, ""};
        } catch (const Error& error) {
            return {nullptr, error.line};
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return {};
}

TEST(ShaderWatch, takes_a_pack_that_was_built_and_says_why_one_was_not) {
    TemporaryFolder folder;
    const std::filesystem::path pack = folder.path() / "shaders.pack";
    std::filesystem::copy_file(kBuilt, pack);
    ShaderWatch watch(folder.path(), fmt::format("cp '{}' '{}' && touch -d 2001-01-01 '{}'", kBuilt.string(), pack.string(), pack.string()));
    EXPECT_EQ(watch.poll(), nullptr);  // it is the one that was there
    watch.build();
    EXPECT_TRUE(watch.is_building());
    const Polled built = poll(watch);
    ASSERT_NE(built.pack, nullptr) << built.error;
    EXPECT_FALSE(built.pack->all().empty());
    EXPECT_FALSE(watch.is_building());

    ShaderWatch broken(folder.path(), "echo making; echo \"x.comp:7: error: 'a' : undeclared identifier\"; echo more; exit 2");
    broken.build();
    EXPECT_NE(poll(broken).error.find("x.comp:7: error: 'a' : undeclared identifier"), std::string::npos);
    EXPECT_EQ(broken.poll(), nullptr);  // says it once

    ShaderWatch half(folder.path(), fmt::format("head -c 100 '{}' > '{}'", kBuilt.string(), pack.string()));
    half.build();
    EXPECT_NE(poll(half).error.find("this is not a shader pack of this version"), std::string::npos);
}

TEST(ShaderWatch, sees_a_pack_that_somebody_else_built) {
    TemporaryFolder folder;
    const std::filesystem::path pack = folder.path() / "shaders.pack";
    std::filesystem::copy_file(kBuilt, pack);
    ShaderWatch watch(folder.path(), "");
    EXPECT_THROW(watch.build(), Error);
    EXPECT_EQ(watch.poll(), nullptr);
    std::filesystem::last_write_time(pack, std::filesystem::last_write_time(pack) + std::chrono::seconds(1));
    EXPECT_NE(poll(watch).pack, nullptr);
    ShaderWatch nothing({}, "");
    EXPECT_EQ(nothing.poll(), nullptr);
}

}  // namespace
}  // namespace parhelion::testing::shader_watch_test
