# Every package is one of Debian's; packages.txt says why each is there.
find_package(Threads REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(glm REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
find_package(draco REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(zstd REQUIRED)
find_library(WEBP_LIBRARY webp REQUIRED)
find_package(Vulkan REQUIRED COMPONENTS glslc)
if(PARHELION_BUILD_TESTS)
    find_package(GTest REQUIRED)
endif()
find_program(SPIRV_VAL spirv-val REQUIRED)
find_program(SPIRV_OPT spirv-opt REQUIRED)

# parhelion-view, which is built where these are.
find_package(glfw3 QUIET)
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_library(IMGUI_LIBRARY imgui)
find_library(STB_LIBRARY stb)  # that ImGui draws letters with

find_path(VMA_INCLUDE_DIR vk_mem_alloc.h HINTS ${PARHELION_DEPS_ROOT}/usr/include REQUIRED)
find_path(SPIRV_CROSS_INCLUDE_DIR spirv_cross_c.h PATH_SUFFIXES spirv_cross REQUIRED)
find_library(SPIRV_CROSS_LIBRARY spirv-cross-c-shared REQUIRED)
