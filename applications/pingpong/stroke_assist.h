// Strokes for a person who plays ping-pong with the mouse: they put the bat in the ball's way, the stroke
// comes by itself.
//
// From the newest shown state the ball's flight is followed ahead. Where it passes the pointer's ray within
// `capture`, and within the arm's reach, the bat leaves the pointer for the last third of a second, meets the
// ball with the face and the speed that bring it back over the wall, follows through and goes back to where
// the pointer is. A ball that the pointer does not meet is missed, and a pointer that goes away calls the
// stroke off. Strokes go now a little to one side, now to the other, so that a pointer which rests meets few
// balls. Nothing else of the game changes: bat, ball and hand obey the same physics as without. World
// frame, SI. One thread; act() takes up to a few tenths of a millisecond, every hundredth of a second.
#pragma once

#include <optional>
#include <vector>

#include "applications/pingpong/strokes.h"
#include "palpate/core/random.h"
#include "palpate/scene/player.h"

namespace palpate::applications::pingpong {

class StrokeAssist : public scene::InputAssist {
 public:
  static constexpr double kCapture_m = 0.18;  // from the pointer's ray: what a person who is late points past
  static constexpr double kAside_m = 0.15;    // to which side of the wall's middle a button sends the ball
  static constexpr double kVaried_m =
      0.15;  // by how much at most strokes differ there: there is something to follow

  // Of the settings: hand, wrist, largest acceleration and speed, seed. It sees at once and aims exactly.
  StrokeAssist(const scene::SceneDescription& scene, const scene::Reach& reach,
               const scene::PlayerSettings& settings);

  void show(const scene::SceneState& state) override;
  std::optional<device::HandTarget> act(Instant<PhysicsClock> now, const scene::Led& led) override;

 private:
  // Where the ball could be met and the pointer lies, the best place first.
  std::vector<Meeting> places(double now, const scene::Led& led) const;
  void think(double now, const scene::Led& led);

  scene::PlayerSettings settings_;
  Strokes strokes_;
  std::optional<scene::SceneState> shown_;
  int bounces_before_ = 0;  // of the table, when the ball last came from serve, wall or bat
  bool news_ = false;
  double thought_ = 0.0;  // s, when last
  std::optional<Swing> swing_;
  double varied_ = 0.0;  // m, of this stroke
  Random random_;
  scene::HandTrajectory hand_;
};

}  // namespace palpate::applications::pingpong
