// A pose from the numbers of a row, as every form's reader makes it; and what trackers write where they see nothing.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/device/pose_file.h"
#include "palpate/formats/content.h"

namespace palpate::formats {

// x y z, qw qx qy qz
using PoseNumbers = std::array<std::optional<double>, 7>;

// None is a finite number of a size that a tracker measures, or all are 0: the body was hidden.
bool is_hidden(const PoseNumbers& numbers);
// Every one is.
bool is_whole(const PoseNumbers& numbers);
// Wrong use where the quaternion's length is not 1 within 2 %, and where the place is out of all reach.
Expected<device::StampedPose> pose_of(const PoseNumbers& numbers, double metres_per_unit,
                                      const std::string& where);

// Wrong use where a number is missing, or larger than any of a transform between things of this world.
Expected<Transform> transform_of(const Eigen::Matrix4d& matrix, const std::string& where);
// The same of a place, m.
Expected<Vector3> place_of(const Vector3& place, const std::string& where);

}  // namespace palpate::formats
