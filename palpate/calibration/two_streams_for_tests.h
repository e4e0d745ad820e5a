// Two streams of a hand-eye calibration made from a known truth, and a real recording, for tests only.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "palpate/calibration/hand_eye.h"
#include "palpate/core/random.h"

namespace palpate::calibration {

// A head that looks at a board: smooth turning about all axes, known transforms, two streams with their own
// rates.
struct TwoStreams {
  Pose<CameraMarker, CameraOptical> X{so3_exp(Vector3(0.1, -0.2, 3.0)), Vector3(0.012, -0.065, 0.034)};
  Pose<World, Board> Z{so3_exp(Vector3(-1.2, 0.3, 0.1)), Vector3(0.1, -1.4, 3.2)};  // before the camera
  double delay = 0.137;  // hand time = eye time + delay
  double seconds = 30.0;
  double hand_rate = 100.0, eye_rate = 30.0;
  double eye_turn_noise = 0.0, eye_place_noise = 0.0;  // rad, m
  double hand_turn_noise = 0.0, hand_place_noise = 0.0;
  // Orientation (rotation vector) and place of the marker in World at hand time t.
  std::function<Vector3(double)> turn = [](double t) {
    return Vector3(0.25 * std::sin(1.7 * t) + 0.1 * std::sin(4.1 * t), 0.35 * std::sin(1.1 * t + 1),
                   0.2 * std::sin(2.3 * t + 2));
  };
  std::function<Vector3(double)> place = [](double t) {
    return Vector3(0.1 * std::sin(0.9 * t), -0.95 + 0.05 * std::sin(1.3 * t), 2.3 + 0.06 * std::cos(0.7 * t));
  };

  Pose<World, CameraMarker> marker(double t) const { return {so3_exp(turn(t)), place(t)}; }

  std::vector<device::StampedPose> hand(Random& random) const {
    std::vector<device::StampedPose> poses;
    for (double t = 0.0; t < seconds; t += 1.0 / hand_rate) {
      const auto pose = marker(t);
      poses.push_back({t, so3_exp(noise(random, hand_turn_noise)) * pose.rotation,
                       pose.translation + noise(random, hand_place_noise)});
    }
    return poses;
  }
  std::vector<device::StampedPose> eye(Random& random) const {
    std::vector<device::StampedPose> poses;
    for (double t = 1.0; t < seconds - 1.0; t += 1.0 / eye_rate) {
      const auto pose = Z.inverse() * marker(t) * X;
      poses.push_back({t - delay, so3_exp(noise(random, eye_turn_noise)) * pose.rotation,
                       pose.translation + noise(random, eye_place_noise)});
    }
    return poses;
  }
  static Vector3 noise(Random& random, double sd) {
    return {random.normal(sd), random.normal(sd), random.normal(sd)};
  }
  double place_error(const HandEyeSolution& s) const {
    return (s.X_marker_camera.translation - X.translation).norm();
  }
  double turn_error(const HandEyeSolution& s) const {
    return angle_between(s.X_marker_camera.rotation, X.rotation);
  }
};

inline std::vector<device::StampedPose> ethz(const char* file) {
  const auto read = device::read_poses(std::string(PALPATE_DATA_DIR) +
                                       "/ethz_handeye_primesense1/2017-04-09-18-13-10_" + file);
  EXPECT_TRUE(read) << (read ? "" : read.error().message);
  return read ? read->poses : std::vector<device::StampedPose>{};
}

}  // namespace palpate::calibration
