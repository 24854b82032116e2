// What is under the pixels' centres: depth, ids and motion against known geometry, the same in every way to trace and however a
// render is cut.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <ranges>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/film_state.h"
#include "session/scene_setup.h"
#include "shared/scene.h"
#include "support/render_fixture.h"

namespace parhelion::testing::first_hit_test {
namespace {

using DVec2 = glm::dvec2;
using DVec3 = glm::dvec3;

constexpr uint32_t kSize = 32;
const float kInfinite = std::numeric_limits<float>::infinity();

// A camera in double, as the passes see it: offsets along right and up span the image.
struct Lens {
    DVec3 position, right, up, forward;
    bool orthographic;

    explicit Lens(const CameraView& view)
        : position(view.position), right(view.right * view.image_half_extents(1.0f).x), up(view.up * view.image_half_extents(1.0f).y), forward(view.forward), orthographic(view.orthographic) {}

    static DVec2 place(DVec2 film_px) { return {2 * film_px.x / kSize - 1, 1 - 2 * film_px.y / kSize}; }
    DVec3 origin(DVec2 film_px) const { return orthographic ? position + place(film_px).x * right + place(film_px).y * up : position; }
    // Not unit: one unit of it goes one metre along the axis.
    DVec3 direction(DVec2 film_px) const { return orthographic ? forward : forward + place(film_px).x * right + place(film_px).y * up; }
    DVec2 project_offset(DVec3 offset, double distance) const {
        const DVec2 p(glm::dot(offset, right) / glm::dot(right, right) / distance, glm::dot(offset, up) / glm::dot(up, up) / distance);
        return DVec2(p.x + 1, 1 - p.y) * (kSize / 2.0);
    }
    DVec2 project(DVec3 point) const { return project_offset(point - position, orthographic ? 1.0 : glm::dot(point - position, forward)); }
};

CameraView aslant() { return look_at({0.3f, 1.7f, 2.9f}, {0.1f, 0.0f, 0.05f}, 0.9f); }

struct Tiles {
    Scene scene;
    Handle<Instance> floor, moving;
};

// A floor of 4 by 4 metres, and above it a mesh of two quads with materials of their own, moved by `place`.
Tiles make_tiles(const glm::mat4& place) {
    SceneEdit edit;
    Primitive floor;
    add_quad(floor, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    Tiles tiles;
    tiles.floor = builtin::add_object(edit, "floor", std::move(floor), edit.add(builtin::lambert("grey", glm::vec3(0.5f))));
    Mesh mesh{.name = "tiles"};
    for (const float x : {-0.8f, 0.1f}) {
        Primitive& tile = mesh.primitives.emplace_back();
        add_quad(tile, {x, 0.0f, 0.5f}, {0.7f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f});
        tile.material = edit.add(builtin::lambert("tile", glm::vec3(0.2f)));
    }
    tiles.moving = edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node_from_object = place}});
    builtin::add_camera(edit, "front", {0.0f, 1.2f, 4.0f}, {0.0f, 0.0f, 0.0f}, 0.8f);
    const ChangeSet changes = tiles.scene.apply(std::move(edit));
    tiles.floor = changes.resolve(tiles.floor), tiles.moving = changes.resolve(tiles.moving);
    return tiles;
}

// Turned, stretched and sheared: no two axes alike.
glm::mat4 uneven(glm::vec3 at, float turn) {
    const float c = std::cos(turn), s = std::sin(turn);
    return glm::mat4(glm::vec4(1.3f * c, 0.1f, 1.3f * s, 0.0f), glm::vec4(0.2f, 0.9f, 0.1f, 0.0f), glm::vec4(-0.7f * s, 0.15f, 0.7f * c, 0.0f), glm::vec4(at, 1.0f));
}

class FirstHits : public GpuTest {
protected:
    static Shot shot(const CameraView& camera, std::vector<std::string> aovs = {"depth", "ids", "motion"}) {
        return {.view = {.width = kSize, .height = kSize, .max_bounces = 1, .aovs = std::move(aovs)}, .camera = camera, .sample_count = 1};
    }
    static const std::vector<uint32_t>& words(const image::FilmSums& film, std::string_view channel) {
        return std::ranges::find(film.exact, channel, &image::ExactLayer::channel)->words;
    }
    static float value(const image::FilmSums& film, std::string_view channel, size_t pixel) { return std::bit_cast<float>(words(film, channel)[pixel]); }
    static DVec2 centre(size_t pixel) { return DVec2(pixel % kSize + 0.5, pixel / kSize + 0.5); }

    // The film of a view that looked through `before` one frame ago.
    static image::FilmSums film_after(Stage& stage, const CameraView& before, const CameraView& now) {
        const Shot settings = shot(now);
        ViewDesc desc = settings.view;
        desc.camera = shader_camera(before, 1.0f);
        View view(stage.frame.device(), desc);
        view.set_camera(shader_camera(now, 1.0f));
        stage.scene_gpu.finish(stage.frame);
        record_reference(stage.frame, stage.scene_gpu, settings.way, view, {0, kSize, 0, 1}, true);
        stage.frame.run();
        return make_film_sums(view.read_film(stage.frame), {kSize, kSize}, {0, 1}, {});
    }

    // Every pixel's motion against its surface's point, or its direction where it sees the sky, in double. Returns how many pixels
    // saw `moving`.
    static size_t check_motion(const image::FilmSums& film, const Tiles& tiles, const glm::mat4& was, const glm::mat4& is, const Lens& before, const Lens& now) {
        size_t seen = 0;
        for (size_t p = 0; p < film.pixel_count(); ++p) {
            const float depth = value(film, "depth", p);
            const DVec3 direction = now.direction(centre(p)), point = now.origin(centre(p)) + double(depth) * direction;
            const bool on_moving = words(film, "ids.instance")[p] == tiles.moving.index;
            const DVec3 point_before = on_moving ? DVec3(glm::dmat4(was) * glm::inverse(glm::dmat4(is)) * glm::dvec4(point, 1)) : point;
            const DVec2 expected = (std::isinf(depth) ? before.project_offset(direction, glm::dot(direction, before.forward)) : before.project(point_before)) - centre(p);
            EXPECT_NEAR(value(film, "motion.X", p), expected.x, 1e-3) << p;
            EXPECT_NEAR(value(film, "motion.Y", p), expected.y, 1e-3) << p;
            seen += on_moving;
        }
        return seen;
    }
};

TEST_F(FirstHits, depth_is_the_distance_along_the_cameras_axis) {
    Stage stage(make_tiles(uneven({0.0f, -5.0f, 0.0f}, 0.0f)).scene);  // nothing but the floor is seen
    const CameraView high = camera_from_above(3.0f, 2.5f);
    for (const CameraView& camera : {aslant(), high}) {
        const image::FilmSums film = stage.render(shot(camera));
        const Lens lens(camera);
        size_t floor = 0;
        for (size_t p = 0; p < film.pixel_count(); ++p) {
            const DVec3 origin = lens.origin(centre(p)), direction = lens.direction(centre(p));
            const double depth = -origin.y / direction.y;
            const DVec3 point = origin + depth * direction;
            const double inside = 2.0 - std::max(std::abs(point.x), std::abs(point.z));
            if (std::abs(inside) < 1e-4) continue;
            const bool meets = depth > 0 && inside > 0;
            floor += meets;
            if (meets) ASSERT_NEAR(value(film, "depth", p), depth, 1e-5 * depth) << p;
            else ASSERT_EQ(value(film, "depth", p), kInfinite) << p;
        }
        EXPECT_GT(floor, 300u);
        EXPECT_LT(floor, film.pixel_count() - 100);
    }
}

TEST_F(FirstHits, ids_name_the_triangle_under_the_pixels_centre) {
    const Tiles tiles = make_tiles(uneven({0.1f, 0.3f, 0.0f}, 0.4f));
    Stage stage(make_tiles(uneven({0.1f, 0.3f, 0.0f}, 0.4f)).scene);
    Shot asked = shot(aslant());
    const Lens lens(*asked.camera);
    const image::FilmSums film = stage.render(asked);
    std::map<uint32_t, size_t> of_instance, of_geometry;
    for (size_t p = 0; p < film.pixel_count(); ++p) {
        const uint32_t instance = words(film, "ids.instance")[p], geometry = words(film, "ids.geometry")[p], triangle = words(film, "ids.primitive")[p];
        if (std::isinf(value(film, "depth", p))) {
            for (const char* channel : {"ids.instance", "ids.geometry", "ids.primitive", "ids.material"}) ASSERT_EQ(words(film, channel)[p], shared::kNone) << channel << ' ' << p;
            continue;
        }
        ASSERT_TRUE(instance == tiles.floor.index || instance == tiles.moving.index) << p;
        const Instance& object = tiles.scene.get(instance == tiles.floor.index ? tiles.floor : tiles.moving);
        const Primitive& primitive = tiles.scene.get(object.mesh).primitives.at(geometry);
        ASSERT_EQ(words(film, "ids.material")[p], primitive.material.index) << p;
        // The point at the pixel's centre, in the triangle's own coordinates.
        const glm::uvec3 corners = primitive.triangles.at(triangle);
        const auto corner = [&](uint32_t i) { return DVec3(object.place.world_from_object * glm::vec4(primitive.positions.at(i), 1.0f)); };
        const DVec3 a = corner(corners.x), e1 = corner(corners.y) - a, e2 = corner(corners.z) - a, normal = glm::cross(e1, e2);
        const DVec3 point = lens.origin(centre(p)) + double(value(film, "depth", p)) * lens.direction(centre(p)) - a;
        ASSERT_NEAR(glm::dot(point, glm::normalize(normal)), 0.0, 1e-5) << p;
        const double u = glm::dot(glm::cross(point, e2), normal) / glm::dot(normal, normal), v = glm::dot(glm::cross(e1, point), normal) / glm::dot(normal, normal);
        ASSERT_GE(std::min({u, v, 1 - u - v}), -1e-5) << p;
        ++of_instance[instance];
        if (instance == tiles.moving.index) ++of_geometry[geometry];
    }
    EXPECT_GT(of_instance[tiles.floor.index], 100u);
    EXPECT_GT(of_geometry[0], 8u);
    EXPECT_GT(of_geometry[1], 8u);
}

TEST_F(FirstHits, what_stands_still_has_no_motion_at_all) {
    Stage stage(make_tiles(uneven({0.1f, 0.3f, 0.0f}, 0.4f)).scene);
    const image::FilmSums film = stage.render(shot(aslant()));
    for (size_t p = 0; p < film.pixel_count(); ++p) ASSERT_EQ(glm::vec2(value(film, "motion.X", p), value(film, "motion.Y", p)), glm::vec2(0.0f)) << p;
}

TEST_F(FirstHits, motion_follows_the_camera_and_the_instance) {
    const glm::mat4 was = uneven({-0.2f, 0.25f, 0.15f}, -0.3f);
    glm::mat4 is = uneven({0.1f, 0.3f, 0.0f}, 0.4f);
    is[0] *= 1.4f;  // it also grew along one axis
    Tiles tiles = make_tiles(was);
    const Handle<Instance> moving = tiles.moving;
    Stage stage(std::move(tiles.scene));
    stage.scene_gpu.finish(stage.frame);
    stage.frame.run();
    SceneEdit edit;
    edit.set_transform(moving, is);
    stage.step(std::move(edit));
    const CameraView before = look_at({0.5f, 1.6f, 3.0f}, {0.0f, 0.1f, 0.0f}, 0.8f), now = aslant();
    const image::FilmSums film = film_after(stage, before, now);
    EXPECT_GT(check_motion(film, tiles, was, is, Lens(before), Lens(now)), 30u);
    const auto sky = std::ranges::count_if(words(film, "depth"), [](uint32_t bits) { return std::isinf(std::bit_cast<float>(bits)); });
    EXPECT_GT(sky, 50);

    // A frame later nothing has moved but the orthographic camera.
    stage.step({});
    const CameraView high = camera_from_above(3.0f, 2.5f), wider = camera_from_above(4.0f, 1.9f);
    const image::FilmSums later = film_after(stage, high, wider);
    check_motion(later, tiles, is, is, Lens(high), Lens(wider));
}

TEST_F(FirstHits, what_was_behind_the_camera_has_infinite_motion) {
    Stage stage(make_tiles(uneven({0.1f, 0.3f, 0.0f}, 0.4f)).scene);
    const CameraView away = look_at({0.3f, 1.7f, 2.9f}, {0.3f, 1.7f, 9.0f}, 0.9f);
    const image::FilmSums film = film_after(stage, away, aslant());
    for (size_t p = 0; p < film.pixel_count(); ++p) ASSERT_EQ(value(film, "motion.X", p), kInfinite) << p;
}

// Neither samples nor the pixel filter nor slices change them; rows are taken once.
TEST_F(FirstHits, samples_and_slices_change_nothing) {
    Stage& stage = builtin_stage("builtin:textured");
    Shot whole{.view = {.width = kSize, .height = kSize, .max_bounces = 1, .aovs = {"depth", "ids", "motion"}}, .sample_count = 2};
    const std::vector<image::ExactLayer> expected = stage.render(whole).exact;
    ASSERT_EQ(expected.size(), 7u);
    Shot cut = whole;
    cut.view.filter = PixelFilter::Point;
    cut.first_sample = 64, cut.sample_count = 3, cut.slice_rows = 5, cut.slice_samples = 1;
    EXPECT_EQ(stage.render(cut).exact, expected);
    // Which of the layers are kept is no matter either.
    cut.view.aovs = {"motion"};
    EXPECT_EQ(stage.render(cut).exact, std::vector(expected.end() - 2, expected.end()));
}

TEST_F(FirstHits, sample_0_of_the_point_filter_meets_the_same_surface) {
    Shot both{.view = {.width = kSize, .height = kSize, .max_bounces = 1, .filter = PixelFilter::Point, .aovs = {"normal", "depth"}}, .sample_count = 1};
    const image::ImageF picture = builtin_picture("builtin:spheres", both);
    const std::vector<uint32_t>& depth = picture.exact.at(0).words;
    const std::span<const float> x = picture.plane(3), y = picture.plane(4), z = picture.plane(5);
    for (size_t p = 0; p < picture.pixel_count(); ++p) ASSERT_EQ(std::isinf(std::bit_cast<float>(depth[p])), glm::vec3(x[p], y[p], z[p]) == glm::vec3(0.0f)) << p;
}

TEST_F(FirstHits, every_way_to_trace_gives_the_same_bits) {
    for (const char* scene : {"builtin:cornell", "builtin:textured", "builtin:spheres"}) {
        // A little aside: scenes and cameras are symmetric, and rays would run exactly through edges, where either triangle is right.
        CameraView camera = view_of((*builtin_stage(scene).scene.cameras().begin()).value, 1.0f);
        camera.position += glm::vec3(0.0137f, 0.0071f, 0.0f);
        Shot asked = shot(camera);
        asked.view.width = asked.view.height = 64;
        const std::vector<image::ExactLayer> expected = builtin_film(scene, asked).exact;
        for (const gpu::TraceWay way : {gpu::TraceWay::Query, gpu::TraceWay::Pipeline}) {
            if (!device()->caps().supports(way)) continue;
            asked.way = way;
            const std::vector<image::ExactLayer> found = builtin_film(scene, asked).exact;
            size_t different = 0;
            for (size_t p = 0; p < expected[0].words.size(); ++p)
                different += std::ranges::any_of(std::views::iota(size_t{0}, expected.size()), [&](size_t i) { return found[i].words[p] != expected[i].words[p]; });
            EXPECT_LE(different, expected[0].words.size() / 1000) << scene << ' ' << gpu::trace_way_name(way);
        }
    }
}

}  // namespace
}  // namespace parhelion::testing::first_hit_test
