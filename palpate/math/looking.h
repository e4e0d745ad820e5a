// Where a camera is that looks at something. A pure function; any thread.
#pragma once

#include "palpate/math/pose.h"

namespace palpate::inline math {

// X_world_camera of a camera at `eye` that looks at `target`, m, World; up in the world (+y) is up in the picture. Looking
// straight up or down, +x is to the right.
Pose<World, CameraOptical> looking(const Vector3& eye, const Vector3& target);

}  // namespace palpate::inline math
