#include "palpate/calibration/internal/hand_eye_roles.h"

#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::calibration {
namespace {

const double kInView = radians_from_degrees(45.0);  // of the optical axis: a picture 90 deg wide
constexpr double kNearlyAll = 0.9, kHardlyAny = 0.5;

// The share of poses from which the origin of the frame they are reported in lies within `angle` of the body's +z.
double share_ahead(const std::vector<device::StampedPose>& poses, double angle) {
  const auto ahead = std::count_if(poses.begin(), poses.end(), [&](const device::StampedPose& pose) {
    const Vector3 origin = pose.rotation.conjugate() * -pose.translation;
    return origin.z() > std::cos(angle) * origin.norm();
  });
  return static_cast<double>(ahead) / static_cast<double>(std::max<std::size_t>(1, poses.size()));
}

}  // namespace

std::string doubt_of_roles(const std::vector<device::StampedPose>& hand,
                           const std::vector<device::StampedPose>& eye) {
  const double by_hand = share_ahead(hand, kInView), by_eye = share_ahead(eye, kInView);
  if (by_hand > kNearlyAll && by_eye < kHardlyAny)
    return fmt::format(
        "hand and eye seem to be exchanged: what is given as the hand looks at the origin of its frame in "
        "{:.0f} % "
        "of its poses, as a camera does at its board, what is given as the eye in {:.0f} %",
        100.0 * by_hand, 100.0 * by_eye);
  const double behind = 1.0 - share_ahead(eye, radians_from_degrees(90.0));
  if (behind > kNearlyAll)
    return fmt::format(
        "the board would be behind the camera in {:.0f} % of the eye poses: are hand and eye exchanged, or "
        "the eye's "
        "poses those of the board in the camera?",
        100.0 * behind);
  return "";
}

}  // namespace palpate::calibration
