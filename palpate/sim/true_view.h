// Everything the simulated camera needs to take one picture of the real (simulated) world: truth, for sim
// only.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "palpate/device/camera_model.h"
#include "palpate/device/holding_hand.h"
#include "palpate/device/phantom.h"
#include "palpate/math/pose.h"

namespace palpate::sim {

struct Dot {  // a round landmark glued onto a surface
  Vector3 centre;
  Vector3 normal;
  double diameter = 0.008;
};

struct RealBall {  // a ball somebody has put there: what a virtual one at its place must look like
  Vector3 centre;
  double radius = 0.020;
};

// The person's hand at the stylus, if it is seen; people's differ.
struct TrueHand {
  device::HoldingHand side = device::HoldingHand::none;
  double size = 1.0;   // over the median's
  double along = 0.0;  // m, further up the handle
  double roll = 0.0;   // rad, about the handle
  bool operator==(const TrueHand&) const = default;
};

struct TrueView {
  device::CameraModel lens;
  Pose<World, CameraOptical> X_world_camera;
  std::array<Vector3, 4> table{}, wall{};  // corners, in touching order
  std::vector<Dot> dots;
  std::vector<RealBall> balls;
  // The real arm: base, links, gimbal, stylus with its marker. Nothing virtual is here.
  Pose<World, ArmBase> X_world_base;
  device::PhantomLengths lengths;
  Vector3 theta = Vector3::Zero(), gimbal = Vector3::Zero();
  Pose<Tip, TipMarker> X_tip_marker;
  std::vector<Vector3> marker_leds;
  TrueHand hand;
  std::optional<Pose<World, Board>> board;  // a chessboard with 10 x 7 squares (9 x 6 inner corners)
  double board_square = 0.025;
  double noise_sd = 0.0;         // grey levels of 255
  std::uint64_t noise_seed = 0;  // changes every frame
};

// Where the stylus tip truly is.
inline Vector3 true_tip(const TrueView& view) {
  return (view.X_world_base * device::phantom_tip(view.theta, view.lengths)).m;
}

}  // namespace palpate::sim
