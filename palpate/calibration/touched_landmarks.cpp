#include "palpate/calibration/touched_landmarks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::calibration {
namespace {

constexpr double kOneDot = 0.005;  // m; touches further from their mean are of two dots

struct Nearest {
  const rig::SurfaceCalibration* surface = nullptr;
  double distance = std::numeric_limits<double>::infinity();
};

Nearest nearest_surface(const Vector3& place, const std::vector<rig::SurfaceCalibration>& surfaces) {
  Nearest nearest;
  for (const auto& surface : surfaces) {
    const Vector3 normal = surface.X_world_rectangle.rotation * Vector3::UnitZ();
    const double distance = std::abs(normal.dot(place - surface.corner(0).m));
    if (distance < nearest.distance) nearest = {&surface, distance};
  }
  return nearest;
}

}  // namespace

Expected<Estimate<TouchedLandmarks>> landmarks_from_touches(
    const std::vector<LandmarkTouch>& touches, const std::vector<rig::SurfaceCalibration>& surfaces,
    const LandmarkTouchOptions& options) {
  if (touches.empty()) return refused("landmarks: no touches; touch the middle of each dot");
  if (surfaces.empty())
    return refused(
        "landmarks: no surface is calibrated on which they could lie; palpate calibrate surface first");
  Estimate<TouchedLandmarks> estimate;
  TouchedLandmarks& found = estimate.value;
  std::vector<std::size_t> landmark_of;
  std::vector<Vector3> sum;
  std::vector<Matrix3> tracker;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    if (!touches[i].place.allFinite() || !touches[i].tracker.allFinite())
      return refused("landmarks: touch {} is not finite; touch it again", i + 1);
    const auto at = std::find(found.labels.begin(), found.labels.end(), touches[i].label);
    landmark_of.push_back(static_cast<std::size_t>(at - found.labels.begin()));
    if (at == found.labels.end()) {
      found.labels.push_back(touches[i].label);
      found.touches.push_back(0);
      sum.push_back(Vector3::Zero());
      tracker.push_back(Matrix3::Zero());
    }
    const std::size_t k = landmark_of.back();
    ++found.touches[k];
    sum[k] += touches[i].place;
    tracker[k] += touches[i].tracker;
  }

  double square = 0.0;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const std::size_t k = landmark_of[i];
    estimate.residuals.push_back(touches[i].place - sum[k] / found.touches[k]);
    const double off = estimate.residuals.back().norm();
    square += off * off;
    if (off > kOneDot)
      return refused(
          "landmarks: touch {} lies {:.1f} mm from the mean of '{}', at most {:.0f} mm is accepted; touch it "
          "again, or label two dots differently",
          i + 1, mm_from_metres(off), excerpt(touches[i].label), mm_from_metres(kOneDot));
  }
  const double freedoms = 3.0 * static_cast<double>(touches.size() - found.labels.size());
  found.touch = options.touch;
  if (freedoms > 0.0) found.touch = noise::pooled(options.touch, {std::sqrt(square / freedoms), freedoms});

  const auto size = 3 * static_cast<Eigen::Index>(found.labels.size());
  estimate.covariance = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t k = 0; k < found.labels.size(); ++k) {
    const double n = found.touches[k];
    rig::Landmark landmark;
    landmark.place = {sum[k] / n};
    landmark.covariance = tracker[k] / n + found.touch.sd * found.touch.sd / n * Matrix3::Identity();
    landmark.diameter = options.diameter;
    const auto nearest = nearest_surface(landmark.place.m, surfaces);
    landmark.normal = nearest.surface->X_world_rectangle.rotation * Vector3::UnitZ();
    found.surface.push_back(nearest.surface->name);
    found.distance.push_back(nearest.distance);
    estimate.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(k), 3 * static_cast<Eigen::Index>(k)) =
        landmark.covariance;
    found.landmarks.push_back(landmark);
  }
  return estimate;
}

}  // namespace palpate::calibration
