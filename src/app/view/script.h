#pragma once
// What a viewer does by itself (--script): for tests, and to see the same thing twice.
#include <string>
#include <vector>

#include "app/view/controls.h"

namespace parhelion::view {

class Script {
public:
    // Steps as `name` or `name=value`, separated by commas. Throws a usage Error for one that does not exist or has a wrong value.
    explicit Script(const std::string& text);

    // After a frame has been shown: does the steps up to the next that has to wait. False: all are done.
    bool run(Window& window, Interactive& session, Controls& controls);

private:
    struct Step {
        std::string name, value;
    };
    bool wait(const Step& step, const Interactive& session);  // true: not yet
    void act(const Step& step, Window& window, Interactive& session, Controls& controls);

    std::vector<Step> steps_;
    size_t next_ = 0;
    bool begun_ = false;  // the next step has been acted on, and waits
    uint64_t frames_ = 0;  // since then
};

}  // namespace parhelion::view
