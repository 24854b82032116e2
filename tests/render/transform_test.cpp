// An instance is its mesh with the transform applied: points, normals and facing against the same surface built in place.
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::transform_test {
namespace {

// A turned, stretched, moved plane with normals that lean, lit by a point light. `mirrored` turns the mesh inside out as well.
class Transforms : public GpuTest {
protected:
    static Primitive plane() {
        Primitive p;
        add_quad(p, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
        p.normals.assign(p.positions.size(), glm::normalize(glm::vec3(0.2f, 0.9f, -0.15f)));
        return p;
    }
    static glm::mat4 transform(bool mirrored) {
        glm::mat4 m = glm::translate(glm::mat4(1.0f), {0.3f, -0.2f, 0.1f});
        m = glm::rotate(m, 0.5f, glm::vec3(1.0f, 0.4f, 0.3f));
        return glm::scale(m, {mirrored ? -2.0f : 2.0f, 0.5f, 1.3f});
    }
    static image::ImageF draw(bool in_place, bool mirrored, gpu::TraceWay way) {
        SceneEdit edit;
        Primitive p = plane();
        const glm::mat4 m = transform(mirrored);
        if (in_place) {
            for (glm::vec3& x : p.positions) x = glm::vec3(m * glm::vec4(x, 1.0f));
            for (glm::vec3& n : p.normals) n = glm::normalize(glm::inverseTranspose(glm::mat3(m)) * n);
            // Mirroring turns the corners' order over; the outside stays the outside.
            if (mirrored)
                for (glm::uvec3& t : p.triangles) std::swap(t.y, t.z);
        }
        const Handle<Instance> object = builtin::add_object(edit, "plane", std::move(p), edit.add(builtin::lambert("plane", glm::vec3(0.7f))));
        if (!in_place) edit.set_transform(object, m);
        Light lamp{.name = "lamp", .intensity = 100.0f};
        lamp.place.node_from_object = glm::translate(glm::mat4(1.0f), {1.0f, 3.0f, 0.5f});
        edit.add(std::move(lamp));
        Stage stage(make_scene(std::move(edit)));
        return stage.picture({.way = way, .view = {.width = 24, .height = 24, .max_bounces = 1, .filter = PixelFilter::Point, .aovs = {"normal"}}, .camera = camera_from_above(6.0f, 1.0f), .sample_count = 1});
    }
};

}  // namespace

TEST_F(Transforms, a_transformed_instance_is_the_mesh_built_in_place) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        for (const bool mirrored : {false, true}) {
            const image::ImageF there = draw(false, mirrored, way), built = draw(true, mirrored, way);
            EXPECT_GT(mean_rgb(built), 0.5);
            for (size_t i = 0; i < there.data.size(); ++i)
                ASSERT_NEAR(there.data[i], built.data[i], 2e-4 * std::abs(built.data[i]) + 2e-5) << gpu::trace_way_name(way) << ", value " << i << (mirrored ? ", mirrored" : "");
        }
    }
}

}  // namespace parhelion::testing::transform_test
