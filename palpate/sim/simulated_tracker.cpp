#include "palpate/sim/simulated_tracker.h"

#include <Eigen/LU>

namespace palpate::sim {

SimulatedTracker::SimulatedTracker(const config::WorldFile& world, std::uint64_t seed, std::uint64_t chance)
    : bias_fields_{SmoothField(seed, "tracker/bias-0", world.tracker.bias_correlation),
                   SmoothField(seed, "tracker/bias-1", world.tracker.bias_correlation),
                   SmoothField(seed, "tracker/bias-2", world.tracker.bias_correlation)},
      cos_max_angle_(std::cos(world.tracker.max_led_angle)),
      dropout_(world.tracker.dropout),
      white_(chance, "tracker/white"),
      dropouts_(chance, "tracker/dropout") {
  const auto& t = world.tracker;
  Vector3 middle = Vector3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    // The outer two measure sideways, the middle one up and down.
    const Vector3 direction = i == 1 ? Vector3(Vector3::UnitY()) : Vector3(t.cameras[2] - t.cameras[0]);
    cameras_[i] = LinearCamera::aimed(t.cameras[i], t.look_at, direction);
    middle += t.cameras[i] / 3.0;
  }
  const Vector3 reference = middle + t.optimal_distance * (t.look_at - middle).normalized();
  const double gain = triangulation_gain(cameras_, reference);
  white_sd_ = t.white_rms / gain;
  bias_sd_ = t.bias_rms / gain;
}

bool SimulatedTracker::visible(const Vector3& place, const Vector3& normal) const {
  for (const auto& camera : cameras_) {
    const Vector3 towards = camera.place - place;
    if (normal.dot(towards) < cos_max_angle_ * towards.norm()) return false;
    if (camera.depth(place) < 0.05) return false;
  }
  return true;
}

std::optional<LedPoint> SimulatedTracker::triangulate_noisy(const Vector3& place) {
  std::array<double, 3> u{};
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = cameras_[i].measure(place) + white_.normal(white_sd_);
    if (bias_sd_ > 0.0) u[i] += bias_sd_ * bias_fields_[i].at(place);
  }
  return triangulate(cameras_, u, white_sd_);
}

std::optional<LedPoint> SimulatedTracker::measure_led(const Vector3& place) {
  return triangulate_noisy(place);
}

Vector3 SimulatedTracker::bias(const Vector3& place) const {
  std::array<double, 3> u{};
  for (std::size_t i = 0; i < 3; ++i)
    u[i] = cameras_[i].measure(place) + bias_sd_ * bias_fields_[i].at(place);
  const auto point = triangulate(cameras_, u, white_sd_);
  return point ? Vector3(point->place - place) : Vector3::Zero();
}

Matrix3 SimulatedTracker::stated_systematic(const Vector3& place) const {
  std::array<double, 3> u{};
  for (std::size_t i = 0; i < 3; ++i) u[i] = cameras_[i].measure(place);
  const auto point = triangulate(cameras_, u, bias_sd_);
  return point ? point->covariance : Matrix3(Matrix3::Zero());
}

device::TrackerSample SimulatedTracker::measure(Instant<TrackerClock> stamp, const SeenBody& body) {
  device::TrackerSample sample;
  sample.stamp = stamp;
  sample.marker = body.marker;
  if (!body.present) return sample;
  std::vector<Vector3> model;
  std::vector<LedPoint> seen;
  const Vector3 normal = body.rotation * body.normal;
  for (const auto& led : *body.leds) {
    const bool dropped = dropouts_.chance(dropout_);
    const Vector3 place = body.rotation * led + body.translation;
    if (dropped || !visible(place, normal)) continue;
    if (const auto point = triangulate_noisy(place)) {
      model.push_back(led);
      seen.push_back(*point);
    }
  }
  sample.leds = static_cast<int>(seen.size());
  if (const auto fit = fit_body(model, seen)) {
    sample.seen = true;
    sample.rotation = fit->rotation;
    sample.translation = fit->translation;
    sample.covariance = fit->covariance;
    sample.systematic = stated_systematic(fit->translation);
  }
  return sample;
}

}  // namespace palpate::sim
