#include "palpate/formats/internal/pose_numbers.h"

#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"

namespace palpate::formats {
namespace {

// NDI's programs write -3.697314E28 where nothing was seen.
constexpr double kNobodySawThat = 1e25;

bool is_measured(const std::optional<double>& number) { return number && std::abs(*number) < kNobodySawThat; }

}  // namespace

bool is_hidden(const PoseNumbers& n) {
  return std::none_of(n.begin(), n.end(), is_measured) ||
         std::all_of(n.begin(), n.end(), [](const auto& one) { return one && *one == 0.0; });
}

bool is_whole(const PoseNumbers& n) { return std::all_of(n.begin(), n.end(), is_measured); }

Expected<device::StampedPose> pose_of(const PoseNumbers& n, double metres_per_unit,
                                      const std::string& where) {
  const double length = std::sqrt(*n[3] * *n[3] + *n[4] * *n[4] + *n[5] * *n[5] + *n[6] * *n[6]);
  if (!(std::abs(length - 1.0) <= 0.02))
    return wrong_use(
        "{}: the quaternion has length {:.4g}, a rotation (length 1) is expected; remove or repair the row",
        where, length);
  device::StampedPose pose;
  pose.rotation = Quaternion(*n[3] / length, *n[4] / length, *n[5] / length, *n[6] / length);
  pose.translation = metres_per_unit * Vector3(*n[0], *n[1], *n[2]);
  const double largest = pose.translation.cwiseAbs().maxCoeff();
  if (!(largest <= kFarthestPlace))
    return wrong_use("{}: is {:.3g} m away, at most {:g} m is expected; check the unit or remove the row",
                     where, largest, kFarthestPlace);
  return pose;
}

Expected<Transform> transform_of(const Eigen::Matrix4d& matrix, const std::string& where) {
  constexpr double kLargestScale = 1e6;
  // A comparison that NaN does not pass.
  const auto within = [](const auto& numbers, double limit) {
    return (numbers.array().abs() <= limit).all();
  };
  if (within(matrix.topLeftCorner<3, 3>(), kLargestScale) &&
      within(matrix.topRightCorner<3, 1>(), kFarthestPlace))
    return Transform{matrix};
  return wrong_use("{}: a number is missing, or so large that this is no transform; check the unit", where);
}

Expected<Vector3> place_of(const Vector3& place, const std::string& where) {
  if ((place.array().abs() <= kFarthestPlace).all()) return place;
  return wrong_use(
      "{}: a number is missing, or the place more than {:g} m away; check the unit or remove the row", where,
      kFarthestPlace);
}

}  // namespace palpate::formats
