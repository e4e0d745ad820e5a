// Touched points into the rectangle fit: in order, and with corners numbered; and as landmarks on that
// rectangle.
#include "fuzz/check.h"
#include "palpate/calibration/surface.h"
#include "palpate/calibration/touched_landmarks.h"
#include "palpate/device/point_file.h"

namespace palpate::fuzz {

Refusals surfaces(std::string_view file) {
  Refusals refusals;
  const auto read = device::parse_points(file, "surface.csv");
  if (!answered(read, refusals)) return refusals;
  std::vector<calibration::TouchedPoint> points;
  for (const auto& point : read->points) points.push_back({{point}, 0});
  const auto corner = read->table.find("corner");
  for (std::size_t i = 0; corner && i < points.size(); ++i)
    if (const double number = read->table.rows[i][*corner]; number >= 0.0 && number <= 5.0)
      points[i].corner = static_cast<int>(number);  // 5: out of range for the fit to find
  cut(points);
  const auto fit = calibration::fit_rectangle(points);
  if (!answered(fit, refusals)) return refusals;
  hold_finite(fit->value.X_world_rectangle, "a rectangle's pose is rigid");
  hold(fit->value.width > 0.0 && fit->value.height > 0.0, "a rectangle has sides");
  rig::SurfaceCalibration surface;
  surface.X_world_rectangle = fit->value.X_world_rectangle;
  std::vector<calibration::LandmarkTouch> touches;
  for (std::size_t i = 0; i < points.size(); ++i)
    touches.push_back({read->labels.empty() ? std::to_string(i) : read->labels[i], points[i].place.m});
  const auto landmarks = calibration::landmarks_from_touches(touches, {surface});
  if (!answered(landmarks, refusals)) return refusals;
  for (const auto& landmark : landmarks->value.landmarks)
    hold_finite(landmark.place.m, "a landmark's place is finite");
  return refusals;
}

}  // namespace palpate::fuzz
