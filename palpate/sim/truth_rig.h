// A rig whose calibrations are the truth: for whoever wants what comes after calibration, and nothing of its errors.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

#include "palpate/rig/rig.h"
#include "palpate/sim/simulator.h"

namespace palpate::sim {

inline rig::SurfaceCalibration true_surface(const std::string& name, const config::Corners& corners) {
  rig::SurfaceCalibration surface;
  surface.name = name;
  const Vector3 x = corners[1] - corners[0], y = corners[3] - corners[0];
  Matrix3 R;
  R << x.normalized(), y.normalized(), x.cross(y).normalized();
  surface.X_world_rectangle = {Quaternion(R), corners[0]};
  surface.width = x.norm();
  surface.height = y.norm();
  return surface;
}

inline rig::Rig truth_rig(const Simulator& world) {
  const auto& truth = world.truth();
  rig::Rig rig;
  rig.arm.emplace();
  rig.arm->model.lengths = truth.lengths;
  rig.arm->correction = truth.joints;
  rig.arm->X_world_base = truth.X_world_base;
  rig.arm->tip_in_marker = truth.tip_in_marker;
  rig.arm->gimbal_gain = truth.gimbal.gain;
  rig.arm->gimbal_offset = truth.gimbal.offset;
  rig.camera.emplace();
  rig.camera->model = truth.lens;
  rig.hand_eye.emplace();
  rig.hand_eye->X_marker_camera = truth.X_marker_camera;
  if (world.file().camera.count > 1) {
    rig.right_camera.emplace();
    rig.right_camera->model = truth.right_lens;
    rig.right_hand_eye.emplace();
    rig.right_hand_eye->X_marker_camera = truth.X_marker_right_camera;
  }
  rig.delays.emplace();
  rig.delays->tracker_after_arm_s = world.file().tracker.latency_s;
  rig.delays->camera_after_tracker_s = world.file().camera.latency_s - world.file().tracker.latency_s;
  rig.surfaces = {true_surface("table", truth.table), true_surface("wall", truth.wall)};
  for (const auto& dot : truth.landmarks)
    rig.landmarks.push_back({{dot.centre}, Matrix3::Identity() * 1e-8, dot.normal, dot.diameter});
  return rig;
}

// A rig is of one laboratory: by how much its arm puts the tip elsewhere than this one does, m. Its base alone would not tell, as
// it turns with the first joint's offset. Of an arm that states its place it does. Beyond any measure where the kinds differ.
inline double away_from_laboratory(const rig::ArmCalibration& arm, const Simulator& world) {
  const bool cartesian = arm.model.kind == device::ArmModel::Kind::cartesian;
  if (cartesian != world.truth().delta.has_value()) return std::numeric_limits<double>::infinity();
  if (cartesian) return (arm.X_world_base.translation - world.truth().X_world_base.translation).norm();
  const auto found = rig::tips_of_arm(arm), there = rig::tips_of_arm(*truth_rig(world).arm);
  if (found.size() != there.size()) return std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) most = std::max(most, (found[i].m - there[i].m).norm());
  return most;
}
// More than a calibration leaves, m: some tenths of a millimetre where the arm was held, more beyond.
inline constexpr double kOtherLaboratory = 0.005;

}  // namespace palpate::sim
