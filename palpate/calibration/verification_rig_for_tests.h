// A rig on paper, with errors of the size it states, and what its devices would show: forward by the kinematics' and the
// camera's own formulas, not by what the verification predicts with.
#pragma once

#include "palpate/calibration/verification.h"
#include "palpate/core/units.h"
#include "palpate/device/phantom.h"
#include "palpate/math/looking.h"
#include "palpate/math/random_vector.h"

namespace palpate::calibration {

// Deviations of the calibration's errors, all independent.
struct PaperErrors {
  double gain = 5e-4, offset = 5e-4, base_turn = 5e-4, base = 1e-4, tip = 5e-5, pointer = 5e-5;
  double surface_turn = 2e-4, corner = 1e-4, side = 1e-4, focus = 0.2, principal = 0.2, distortion = 1e-4;
  double eye_turn = 2e-4, eye = 1e-4, landmark = 1e-4, delay = 2e-4;
};
struct PaperNoise {
  double turn = 4e-4, shift = 8e-5, systematic = 6e-5, touch = 3e-4, pixel = 0.05, delay = 1e-4;
};

inline rig::Rig paper_truth() {
  rig::Rig rig;
  rig.arm.emplace();
  rig.arm->correction.gain = Vector3(1.01, 0.99, 1.005);
  rig.arm->correction.offset = Vector3(0.0, 0.02, -0.01);
  rig.arm->X_world_base = {so3_exp({0.02, -0.07, 0.01}), {0.10, -1.40, 1.75}};
  rig.arm->tip_in_marker = {0.004, -0.018, -0.118};
  rig.pointer_pivot.emplace();
  rig.pointer_pivot->tip_in_marker = {-0.010, -0.015, 0.160};
  rig::SurfaceCalibration table;
  table.name = "table";
  Matrix3 R;
  R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  table.X_world_rectangle = {Quaternion(R), {-0.375, -1.52, 1.80}};
  table.width = 0.75;
  table.height = 1.0;
  rig.surfaces = {table};
  rig.camera.emplace();
  rig.camera->model = {640, 480, 560.0, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};
  rig.hand_eye.emplace();
  rig.hand_eye->X_marker_camera = {so3_exp({0.05, -0.04, 3.10}), {0.012, -0.065, 0.034}};
  for (int i = 0; i < 8; ++i)
    rig.landmarks.push_back(
        {{{-0.33 + 0.22 * (i % 4), i < 4 ? -1.52 : -1.35 + 0.02 * i, i < 4 ? 1.6 - 0.15 * i : 0.8}}});
  rig.delays.emplace();
  rig.delays->tracker_after_arm_s = 0.010;
  rig.delays->camera_after_tracker_s = 0.030;
  return rig;
}

// As it was calibrated: off by errors that it states.
inline rig::Rig paper_rig(const rig::Rig& truth, Random& random, const PaperErrors& sd = {}) {
  rig::Rig rig = truth;
  Eigen::VectorXd arm(15);
  arm << Vector3::Constant(sd.gain), Vector3(0.0, sd.offset, sd.offset), Vector3::Constant(sd.base_turn),
      Vector3::Constant(sd.base), Vector3::Constant(sd.tip);
  rig.arm->covariance = arm.cwiseAbs2().asDiagonal();
  rig.arm->correction.gain += normal3(random, sd.gain);
  // Here and below one after the other: a call's arguments are drawn in an order that is the compiler's.
  const double roll = random.normal(sd.offset), yaw = random.normal(sd.offset);
  rig.arm->correction.offset += Vector3(0.0, yaw, roll);
  rig.arm->X_world_base.rotation = so3_exp(normal3(random, sd.base_turn)) * rig.arm->X_world_base.rotation;
  rig.arm->X_world_base.translation += normal3(random, sd.base);
  rig.arm->tip_in_marker += normal3(random, sd.tip);
  rig.pointer_pivot->tip_in_marker += normal3(random, sd.pointer);
  rig.pointer_pivot->covariance = sd.pointer * sd.pointer * Matrix3::Identity();
  for (auto& surface : rig.surfaces) {
    surface.X_world_rectangle.rotation =
        so3_exp(normal3(random, sd.surface_turn)) * surface.X_world_rectangle.rotation;
    surface.X_world_rectangle.translation += normal3(random, sd.corner);
    surface.width += random.normal(sd.side);
    surface.height += random.normal(sd.side);
    Eigen::VectorXd own(8);
    own << Vector3::Constant(sd.surface_turn), Vector3::Constant(sd.corner), sd.side, sd.side;
    surface.covariance = own.cwiseAbs2().asDiagonal();
    surface.touch = {3e-4, 1e6};
  }
  auto& lens = rig.camera->model;
  lens.fx += random.normal(sd.focus), lens.fy += random.normal(sd.focus);
  lens.cx += random.normal(sd.principal), lens.cy += random.normal(sd.principal);
  for (std::size_t k = 0; k < 5; ++k) lens.distortion[k] += random.normal(sd.distortion);
  device::LensParameters of_lens = device::LensParameters::Zero();
  of_lens.head<9>() << sd.focus, sd.focus, sd.principal, sd.principal,
      Eigen::VectorXd::Constant(5, sd.distortion);
  rig.camera->covariance = of_lens.cwiseAbs2().asDiagonal();
  auto& eye = rig.hand_eye->X_marker_camera;
  eye.rotation = so3_exp(normal3(random, sd.eye_turn)) * eye.rotation;
  eye.translation += normal3(random, sd.eye);
  rig.hand_eye->covariance.diagonal() << Vector3::Constant(sd.eye_turn * sd.eye_turn),
      Vector3::Constant(sd.eye * sd.eye);
  for (auto& landmark : rig.landmarks) {
    landmark.place.m += normal3(random, sd.landmark);
    landmark.covariance = sd.landmark * sd.landmark * Matrix3::Identity();
  }
  rig.delays->tracker_after_arm_s += random.normal(sd.delay);
  rig.delays->tracker_std_s = rig.delays->camera_std_s = sd.delay;
  return rig;
}

// What a laboratory in which all of `truth` is so shows to somebody with the rig `rig`. The camera's delay of the rig is
// off by `camera_delay_error` (s).
inline RigObservations paper_observations(const rig::Rig& truth, const rig::Rig& rig, Random& random,
                                          double camera_delay_error = 0.0, const PaperNoise& noise = {}) {
  RigObservations seen;
  seen.rest = device::JointVector(rig.arm->rest_readings + normal3(random, rig::kRestTolerance / 3.0));
  Matrix6 marker_noise = Matrix6::Zero();
  marker_noise.diagonal() << Vector3::Constant(noise.turn * noise.turn),
      Vector3::Constant(noise.shift * noise.shift);
  const auto tracked = [&](auto X) {
    X.rotation = (so3_exp(normal3(random, noise.turn)) * X.rotation).normalized();
    X.translation += normal3(random, noise.shift);
    return X;
  };
  for (int i = 0; i < 10; ++i) {
    HeldStylus held;
    const double third = random.uniform(-0.4, 1.0), second = random.uniform(-0.1, 1.2),
                 first = random.uniform(-0.7, 0.7);
    held.joints = device::JointVector(Vector3(first, second, third));
    const auto theta = truth.arm->correction.apply(held.joints);
    const Vector3 tip = (truth.arm->X_world_base * device::phantom_tip(theta, truth.arm->model.lengths)).m;
    const Quaternion turn = so3_exp(normal3(random, 0.5));
    held.X_world_marker = tracked(Pose<World, TipMarker>{turn, tip - turn * truth.arm->tip_in_marker});
    // As the verification takes it: the marker is shifted by a systematic error, and turned by it over 0.15 m.
    held.X_world_marker.translation += normal3(random, noise.systematic);
    held.X_world_marker.rotation =
        so3_exp(normal3(random, noise.systematic / 0.15)) * held.X_world_marker.rotation;
    // What an arm leaves beside.
    held.X_world_marker.translation += normal3(random, 3e-5);
    held.covariance = marker_noise;
    held.systematic = noise.systematic * noise.systematic * Matrix3::Identity();
    seen.held.push_back(held);
  }
  const auto touch = [&](const std::string& what, int index, const Vector3& place) {
    const Quaternion turn = so3_exp(Vector3(0.9, 0.0, 0.0) + normal3(random, 0.3));
    const Vector3 shift = normal3(random, noise.shift), off = normal3(random, noise.touch);
    const Vector3 tip = place + off + shift;
    seen.touched.push_back({what,
                            index,
                            {turn, tip - turn * truth.pointer_pivot->tip_in_marker},
                            noise.shift * noise.shift * Matrix3::Identity()});
  };
  for (int i = 0; i < 4; ++i) touch("table", i, truth.surfaces[0].corner(i).m);
  for (int i = 0; i < 8; i += 2) touch("landmark", i, truth.landmarks[static_cast<std::size_t>(i)].place.m);
  for (int i = 0; i < 12; ++i) {
    const Vector3 aim = normal3(random, 0.08), head = normal3(random, 0.02);
    const auto X_world_camera = looking(Vector3(0.0, -0.95, 2.30) + head, Vector3(0.0, -1.45, 1.30) + aim);
    HeadFrame frame;
    const auto X_world_marker = X_world_camera * truth.hand_eye->X_marker_camera.inverse();
    frame.rate << normal3(random, 0.5), normal3(random, 0.1);
    // The rig asks for the marker's pose a little after, or before, the picture.
    Pose<World, CameraMarker> asked{
        (so3_exp(Vector3(camera_delay_error * frame.rate.head<3>())) * X_world_marker.rotation).normalized(),
        X_world_marker.translation + camera_delay_error * frame.rate.tail<3>()};
    frame.X_world_marker = tracked(asked);
    frame.covariance = marker_noise;
    for (std::size_t k = 0; k < truth.landmarks.size(); ++k) {
      const Vector3 p = (X_world_camera.inverse() * truth.landmarks[k].place).m;
      const device::Pixel pixel = truth.camera->model.project(p);
      const double sd = std::hypot(noise.pixel, 0.03);
      const double v = random.normal(sd), u = random.normal(sd);
      frame.dots.push_back(
          {k, pixel + device::Pixel(u, v), noise.pixel * noise.pixel * Eigen::Matrix2d::Identity()});
    }
    seen.frames.push_back(frame);
  }
  seen.tracker_delay_s = truth.delays->tracker_after_arm_s + random.normal(noise.delay);
  seen.tracker_delay_std_s = noise.delay;
  return seen;
}

}  // namespace palpate::calibration
