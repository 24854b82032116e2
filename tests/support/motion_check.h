#pragma once
// Motion of deforming meshes, as a film's channels tell it, against geometry in double.
#include <vector>

#include "support/render_fixture.h"

namespace parhelion::testing {

// Of pixels that see deforming meshes: how far their motion points from where their point of the surface was, ascending, and how far the fastest moved. Pixels.
struct MotionFound {
    std::vector<double> off;
    double moved = 0;
};
// The film has depth, ids and motion, is square, and shows `now`; nothing has been taken away from either scene. The camera stood still.
MotionFound check_motion(const Scene& now, const Scene& before, const CameraView& camera, const image::FilmSums& film);

}  // namespace parhelion::testing
