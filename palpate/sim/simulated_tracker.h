// The simulated optical tracker: three linear cameras look at every LED of every body, and it answers with
// poses.
//
// Each 1-D measurement carries white noise and a fixed smooth bias field. Both are scaled so that one LED at
// the optimal distance along the line of sight is triangulated with the stated 3-D rms errors; nearer and
// farther the error follows from the geometry. What it reports as covariance is the white noise; its
// bias it does not know, only how large it is at most places: its stated accuracy. World frame = tracker
// frame, metres. One thread.
#pragma once

#include <array>
#include <deque>

#include "palpate/core/random.h"
#include "palpate/device/devices.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/sim/led_tracker.h"
#include "palpate/sim/smooth_field.h"

namespace palpate::sim {

// A rigid body of LEDs at a place, in World.
struct SeenBody {
  device::MarkerId marker = device::MarkerId::tip_marker;
  const std::vector<Vector3>* leds = nullptr;  // body frame
  Vector3 normal = Vector3::UnitZ();           // direction in which the LEDs shine, body frame
  Quaternion rotation = Quaternion::Identity();
  Vector3 translation = Vector3::Zero();
  bool present = true;
};

class SimulatedTracker {
 public:
  // `seed` draws its systematic error, `chance` the noise.
  SimulatedTracker(const config::WorldFile& world, std::uint64_t seed, std::uint64_t chance);
  SimulatedTracker(const config::WorldFile& world, std::uint64_t seed)
      : SimulatedTracker(world, seed, seed) {}

  // One frame of one body as the cameras have it.
  device::TrackerSample measure(Instant<TrackerClock> stamp, const SeenBody& body);
  // One LED at `place` (facing the tracker): noise and bias as in measure. For tests and studies of single
  // LEDs.
  std::optional<LedPoint> measure_led(const Vector3& place);

  std::span<const LinearCamera> cameras() const { return cameras_; }
  double white_sd() const { return white_sd_; }  // of one 1-D measurement
  // The systematic error of the triangulated place of an LED there, m.
  Vector3 bias(const Vector3& place) const;
  // Covariance of one LED's bias over draws of the field, m^2: what a maker states.
  Matrix3 stated_systematic(const Vector3& place) const;

 private:
  bool visible(const Vector3& place, const Vector3& normal) const;
  std::optional<LedPoint> triangulate_noisy(const Vector3& place);

  std::array<LinearCamera, 3> cameras_;
  std::array<SmoothField, 3> bias_fields_;
  double white_sd_ = 0.0, bias_sd_ = 0.0;  // of one 1-D measurement (tangent of the angle)
  double cos_max_angle_ = 0.0, dropout_ = 0.0;
  Random white_, dropouts_;
};

}  // namespace palpate::sim
