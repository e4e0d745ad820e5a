// What a PHANToM-class arm looks like: its parts as meshes, and where they are for given joint angles.
//
// Drawn by the simulated camera as the real arm, and by the compositor as an invisible body that hides
// virtual things. Frames: each part has a frame of its own, placed in ArmBase by arm_part_poses. Lengths come
// from PhantomLengths, the rest is modelled after photographs of such arms and stands for no particular one.
// Pure values.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "palpate/device/phantom.h"
#include "palpate/math/pose.h"
#include "palpate/scene/mesh.h"

namespace palpate::render {

enum class ArmFrame : int { base, turntable, upper, rod, forearm, stylus, marker, count };
enum class ArmLook : int { black, metal, dark, bright, red, skin };

struct ArmPart {
  scene::TriangleMesh mesh;
  ArmFrame frame;
  ArmLook look;
};

struct ArmConfiguration {
  Pose<World, ArmBase> X_world_base;
  device::PhantomLengths lengths;
  Vector3 theta = Vector3::Zero(), gimbal = Vector3::Zero();
  Pose<Tip, TipMarker> X_tip_marker;
};

struct ArmShapeSettings {
  double base_below = 0.12;         // m, from ArmBase's origin down to what the arm stands on
  std::span<const Vector3> leds;    // m, marker frame; none: no marker is drawn
  int segments = 20;                // round the tubes
  std::span<const ArmPart> more{};  // what moves with the arm besides: the hand that holds it
};

std::vector<ArmPart> arm_parts(const device::PhantomLengths& lengths, const ArmShapeSettings& settings);

struct PartFrame;
using PartPose = Pose<ArmBase, PartFrame>;
std::array<PartPose, static_cast<std::size_t>(ArmFrame::count)> arm_part_poses(
    const device::PhantomLengths& lengths, const Vector3& theta, const Vector3& gimbal,
    const Pose<Tip, TipMarker>& X_tip_marker);

}  // namespace palpate::render
