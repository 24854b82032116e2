#pragma once
// The equivalence test of design: the mean of a realtime picture, and of each class of paths, is the reference's.
#include <string>

#include "truth/truth.h"

namespace parhelion::testing {

struct EqualityCase {
    std::string test;             // of the table's row,
    std::string what = {};        // and what of it is tested, before the class' name
    RealtimeOptions options;      // but for the exposure
    uint32_t warm_up = 0;         // frames that are left out
    uint32_t pilot_frames = 8;    // of the runs that tell how many frames are needed: more than a history is long
};

// 32 runs of both, with as many frames and samples as the 0.5 % take (or as the device can do in reasonable time: noise fails); suns are wide (truth_stage). Of equal pictures each row
// fails once in some hundred times by chance (its tiles: once in a thousand); seeds are fixed.
void expect_equal_classes(const TruthScene& scene, const EqualityCase& of);

}  // namespace parhelion::testing
