// The truth of one simulated laboratory: the world file's values with everything called sd drawn for a seed,
// and then moved by what the file's knock says.
//
// SI and radians. Only sim, tests, `world sample ... truth.json` and the report may look at it. Each quantity
// draws from a generator of its own, so that switching one sd off leaves the others as they were.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "palpate/device/arm_model.h"
#include "palpate/device/camera_model.h"
#include "palpate/device/phantom.h"
#include "palpate/math/pose.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/sim/delta_arm.h"
#include "palpate/sim/true_view.h"

namespace palpate::sim {

struct Truth {
  device::PhantomLengths lengths;
  device::JointCorrection joints, gimbal;  // theta = gain * psi + offset
  std::optional<DeltaArm> delta;           // the arm that states its place, as it was built
  Pose<World, ArmBase> X_world_base;
  Pose<Tip, TipMarker> X_tip_marker;
  Vector3 tip_in_marker = Vector3::Zero();
  Pose<CameraMarker, CameraOptical> X_marker_camera;
  Vector3 pointer_tip = Vector3::Zero();  // in Pointer
  device::CameraModel lens;
  // The second camera's, whether it is there or not (WorldFile's camera.count).
  Pose<CameraMarker, CameraOptical> X_marker_right_camera;
  device::CameraModel right_lens;
  config::Corners table{}, wall{};  // World, in touching order
  std::vector<Dot> landmarks;       // World
  std::vector<Vector3>
      check_points;  // on table and wall, never shown to a procedure: what overlay error is measured on
  Pose<World, Board> X_world_board;  // the calibration board on its stand
};

Truth draw_truth(const config::WorldFile& world, std::uint64_t seed);

// The arm as its maker describes it.
device::ArmModel makers_arm(const config::WorldFile& world);

// The way in which the bodies are built; the file has no key for these.
// LEDs shine along this direction of their body: away from the tip for stylus and pointer; on the head tilted
// up, so that a head that looks down at the table still shows its marker to a tracker that hangs above.
Vector3 tip_marker_normal();
Vector3 camera_marker_normal();
Vector3 pointer_normal();
// Turn of the marker on the stylus: with the stylus as at reset the marker faces a tracker above and in
// front.
Quaternion tip_marker_mount();

// The same arm written with joint offset 1 = 0: that offset and a turn of the base about its vertical axis
// cannot be told apart, and calibrations fix it so. Every tip pose stays as it was.
struct ArmTruth {
  device::PhantomLengths lengths;
  device::JointCorrection joints, gimbal;
  Pose<World, ArmBase> X_world_base;
};
ArmTruth arm_with_first_offset_zero(const Truth& truth);

}  // namespace palpate::sim
