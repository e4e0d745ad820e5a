#include "palpate/calibration/session/step_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"
#include "palpate/math/place_text.h"

namespace palpate::calibration::session {
namespace {

// Of a point's error, mm.
double deviation_mm(const Matrix3& covariance) { return mm_from_metres(std::sqrt(covariance.trace())); }

}  // namespace

std::string words_of_pivot(const rig::PivotCalibration& pivot) {
  return fmt::format("the tip is at {} in its marker, sd {:.2f} mm; residual {:.2f} mm",
                     place_text_mm(pivot.tip_in_marker, 2), deviation_mm(pivot.covariance),
                     pivot.from.rms_mm);
}

std::string words_of_surfaces(const rig::Rig& rig) {
  std::string words;
  for (const auto& surface : rig.surfaces)
    words +=
        fmt::format("{}{}: {:.1f} x {:.1f} mm, residual {:.2f} mm", words.empty() ? "" : "; ", surface.name,
                    mm_from_metres(surface.width), mm_from_metres(surface.height), surface.from.rms_mm);
  return words;
}

std::string words_of_landmarks(const rig::Rig& rig) {
  return fmt::format("{} landmarks", rig.landmarks.size());
}

std::string words_of_arm(const rig::ArmCalibration& arm) {
  return fmt::format("mean error {:.3f} mm in poses that were held back; residual {:.3f} mm",
                     mm_from_metres(arm.held_out_mean), arm.from.rms_mm);
}

std::string words_of_delay(double delay_s, double std_s) {
  return fmt::format("{:.2f} ms, sd {:.2f} ms", 1e3 * delay_s, 1e3 * std_s);
}

std::string words_of_camera(const rig::CameraCalibration& camera, const rig::HandEyeCalibration& hand_eye) {
  const Matrix3 turn = hand_eye.covariance.topLeftCorner<3, 3>(),
                place = hand_eye.covariance.bottomRightCorner<3, 3>();
  return fmt::format(
      "lens: focal length {:.1f} px, residual {:.2f} px; camera in its marker: sd {:.2f} mm, {:.3f} deg",
      camera.model.fx, camera.from.rms_mm, deviation_mm(place),
      degrees_from_radians(std::sqrt(turn.trace())));
}

std::string words_of_places(const rig::Rig& rig) {
  double largest = 0.0;
  for (const auto& landmark : rig.landmarks) largest = std::max(largest, deviation_mm(landmark.covariance));
  return fmt::format("{} landmarks, the least certain of them to {:.2f} mm", rig.landmarks.size(), largest);
}

}  // namespace palpate::calibration::session
