// How the simulated person's head moves: the camera's true pose as a smooth function of time.
//
// In use the head turns about its neck and shakes a little; while calibrating it moves around the board with
// wide turns. A change of manner takes a second. World frame, SI. One thread.
#pragma once

#include "palpate/math/pose.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::sim {

class HeadMotion {
 public:
  HeadMotion(const config::WorldFile& world, const Vector3& board);

  void look(double t) { change(false, t); }
  void look_around_board(double t) { change(true, t); }
  bool settled(double t) const { return t > changed_ + kChange; }

  Pose<World, CameraOptical> at(double t) const;

 private:
  static constexpr double kChange = 1.0;  // s
  void change(bool around, double t);
  double share_around(double t) const;
  Pose<World, CameraOptical> in_use(double t) const;
  Pose<World, CameraOptical> around_board(double t) const;

  Vector3 eye_, look_at_, board_;
  double turn_ = 0.0, turn_hz_ = 0.0, shake_ = 0.0, shake_hz_ = 0.0;
  bool around_ = false;
  double changed_ = -1e9, share_at_change_ = 0.0;
};

}  // namespace palpate::sim
