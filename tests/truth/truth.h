#pragma once
// What the tests of ./dev truth share: scenes, runs of the realtime renderer with a history of their own, and the table that they fill.
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "support/budgets.h"
#include "support/realtime_player.h"
#include "support/render_fixture.h"

namespace parhelion::testing {

// On a CPU device, or with PARHELION_TRUTH_SMALL=1: 32x32 pixels, a few scenes, wider margins, all of it in a few minutes.
bool small_truth();
// PARHELION_TRUTH_EFFORT (1): that many times the frames in which noise may fall.
uint32_t truth_effort();
// PARHELION_TRUTH_REUSE: which reservoirs the tests that are not about them are done with: none (default), full, or history: full, whose temporal reuse
// is not held back where few lights are.
std::string_view truth_reuse();
// `full`, or `small` where the truth is small.
template <class T>
T by_size(T full, T small) {
    return small_truth() ? small : full;
}

// ---- the table ----

// A row: `value` with its interval [low, high] should lie within [least, most].
struct TruthRow {
    std::string test, scene, what;
    double value = 0, low = 0, high = 0;
    double least = 0, most = 0;
    uint32_t runs = 0, frames = 0;  // frames of each run that are averaged
    bool also = true;               // what else must hold
    std::string note = {};
};
// Prints the row as one line, appends it to the file that PARHELION_TRUTH_TABLE names (tabs between cells), and fails the running test
// unless the interval lies within the limits and `also` holds. An interval too wide for its limits is called noise, and fails as well.
void report(const TruthRow& row);
// A row for what was not tested, and why.
void report_skip(const std::string& test, const std::string& scene, const std::string& why);

// ---- scenes ----

struct TruthScene {
    const char* name;
    const char* source;     // builtin:..., or a file of the folder that PARHELION_ASSETS names
    bool small = false;     // also in the small truth
    bool caustics = false;  // light that smooth surfaces throw at diffuse ones
    bool noisy = false;     // takes twice the frames
    glm::vec3 from{0.0f}, at{0.0f};  // where a file's camera stands and looks; equal: one that frames the scene
    float fov_degrees = 45.0f;
};
std::ostream& operator<<(std::ostream& out, const TruthScene& scene);
std::span<const TruthScene> truth_scenes();
inline std::string scene_name(const ::testing::TestParamInfo<TruthScene>& entry) { return entry.param.name; }  // of a test

// A scene that stands on the device, and how it is looked at.
struct TruthStage {
    std::unique_ptr<Stage> stage;
    std::vector<ScriptedEdit> scripted_edits;
    CameraView camera;
    gpu::TraceWay way{};    // the device's own choice
    float exposure = 1.0f;  // metered from this camera
};
// The last one stays for who asks for the same again. Files without any light get the clear sky. Suns get at least this radius (radians): where paths find
// one in a curved mirror by chance, its true disc is found by one path of a billion, which then makes all of a class' mean.
TruthStage& truth_stage(const TruthScene& scene, float least_sun_radius = 0.0f);
TruthStage set_up(LoadedScene loaded, const CameraView& camera);
// Empty if the scene is to be tested here, else why not.
std::string why_skipped(const TruthScene& scene);

// ---- pictures ----

// Pinhole, pixel centres, no clamp, 16 scatterings: what the realtime renderer and its paired reference are drawn with.
ViewDesc truth_view(const TruthStage& on, uint32_t size, uint32_t seed, bool classes);
RealtimeOptions truth_options(const TruthStage& on, bool cache);
// By the reference's paths: on a GPU its wavefront draws them, which is faster and has the same pictures (tests/render/wavefront_equality_test.cpp).
image::ImageF draw_paths(TruthStage& on, const ViewDesc& view, const CameraView& camera, uint32_t samples);
image::ImageF draw_reference(TruthStage& on, uint32_t size, uint32_t seed, uint32_t samples, bool classes = false);

// A run of the realtime renderer: its own seed, its own history.
class TruthRun {
public:
    TruthRun(TruthStage& on, uint32_t size, uint32_t seed, const RealtimeOptions& options, bool classes = false);
    TruthRun(TruthStage& on, const ViewDesc& desc, const RealtimeOptions& options);

    // Before each frame: what happens in the scene (the frame's number, from 0).
    std::function<SceneEdit(uint32_t frame)> script;
    void skip(uint32_t frames);              // draws them for their history alone
    image::ImageF average(uint32_t frames);  // their mean
    // From the next frame on; a cut.
    void look(const CameraView& camera);

private:
    void record(bool last);

    TruthStage& on_;
    View view_;
    Realtime realtime_;
    std::deque<gpu::Ticket> in_flight_;  // the host records ahead of the device
};

std::vector<float> luminance(const image::ImageF& picture, size_t first_channel = 0);
// Runs of one estimator: of the beauty ("picture") and each class ("direct_diffuse", ...).
using ClassRuns = std::map<std::string, Runs>;
void add_run(ClassRuns& runs, const image::ImageF& picture, uint32_t tile_size = Runs::kTileSize);

class TruthTest : public GpuTest {
protected:
    void SetUp() override;  // skips also where there is no world cache
};

}  // namespace parhelion::testing
