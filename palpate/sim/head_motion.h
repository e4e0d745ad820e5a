// How the simulated person's head moves: the camera's true pose as a smooth function of time.
//
// In use the head turns about its neck and shakes a little; while calibrating it moves around the board with
// wide turns. A change of manner takes a second. In use it can be held still: its motion comes to rest within half a
// second, and later goes on from there. World frame, SI. One thread.
#pragma once

#include <optional>

#include "palpate/math/pose.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::sim {

class HeadMotion {
 public:
  HeadMotion(const config::WorldFile& world, const Vector3& board);

  void look(double t) { change(false, t); }
  void look_around_board(double t) { change(true, t); }
  void hold_still(bool still, double t);
  bool settled(double t) const { return t > changed_ + kChange; }

  Pose<World, CameraOptical> at(double t) const;

 private:
  static constexpr double kChange = 1.0;  // s
  static constexpr double kRest = 0.5;    // s, until it stands
  // The head's own time, in which its motion in use is a steady one: since a change it runs towards `rate_after`.
  struct OwnTime {
    double since = 0.0, then = 0.0, rate_before = 1.0, rate_after = 1.0;
    double rate(double t) const;
    double at(double t) const;
  };
  double own_time(double t) const;
  void change(bool around, double t);
  double share_around(double t) const;
  Pose<World, CameraOptical> in_use(double true_time) const;
  Pose<World, CameraOptical> around_board(double t) const;

  Vector3 eye_, look_at_, board_;
  double turn_ = 0.0, turn_hz_ = 0.0, shake_ = 0.0, shake_hz_ = 0.0;
  bool around_ = false;
  double changed_ = -1e9, share_at_change_ = 0.0;
  std::optional<OwnTime> own_time_, own_time_before_;  // none: it has never been held
};

}  // namespace palpate::sim
