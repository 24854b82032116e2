#pragma once
// What a viewer does by itself (--script): for tests, and to see the same thing twice.
#include <string>
#include <vector>

#include "app/view/controls.h"

namespace parhelion::view {

struct ScriptTargets {
    Window& window;
    Interactive& session;
    Panels& panels;
    Controls& controls;
    const ShaderWatch& shaders;
};

class Script {
public:
    // Steps as `name` or `name=value`, separated by commas. Throws a usage Error for one that does not exist or has a wrong value.
    explicit Script(const std::string& text);

    // After a frame has been shown: does the steps up to the next that has to wait. False: all are done. Throws what a step causes, a lost
    // device among it (step `lose`).
    bool run(const ScriptTargets& targets);

private:
    struct Step {
        std::string name, value;
    };
    bool wait(const Step& step, const ScriptTargets& on);  // true: not yet
    void act(const Step& step, const ScriptTargets& on);
    void end(const Step& step, const ScriptTargets& on);   // once it need not wait any more

    void report(const gpu::Device& device);

    std::vector<Step> steps_;
    std::vector<double> frame_seconds_;  // since the last report
    size_t next_ = 0;
    bool begun_ = false;  // the next step has been acted on, and waits
    uint64_t frames_ = 0;  // since then
};

}  // namespace parhelion::view
