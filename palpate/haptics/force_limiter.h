// Makes of any requested force one that a device can follow: peak and slew kept together, impulse not lost.
//
// Two kinds of force come in: a continuous one, which is limited as it is, and impacts, whose IMPULSE counts:
// where a limit cuts an impact's force, what is missing is a backlog that holding the force longer works off,
// so that the hand receives the whole impulse. What cannot be caught up with (fault, start ramp, longer than
// `max_backlog_s`) is lost and counted; at any moment, to rounding,
//   requested = delivered + backlog + lost          N s, of all impacts so far
// N, s, any one frame. Haptic thread alone; does not allocate, lock or throw. docs/theory/forces.md.
#pragma once

#include <limits>

#include "palpate/haptics/force_limits.h"
#include "palpate/math/so3.h"

namespace palpate::haptics {

struct RequestedForce {
  Vector3 continuous = Vector3::Zero();      // N
  Vector3 impact = Vector3::Zero();          // N, mean over the coming tick
  Vector3 impact_to_come = Vector3::Zero();  // N s, impulse of the impacts under way after the coming tick
  bool impact_active = false;

  // Numbers, and none that nobody could ever want of an arm: a continuous force of ten times what the
  // strongest arm gives is a mistake; an impact's short one may be far larger.
  bool good() const {
    constexpr double kMostContinuous = 100.0, kMostImpact = 1e6;  // N
    const auto fine = [](const Vector3& v, double most) {
      return v.cwiseAbs().maxCoeff() < most && v.allFinite();
    };
    return fine(continuous, kMostContinuous) && fine(impact, kMostImpact) &&
           fine(impact_to_come, kMostImpact);
  }
};

// What this tick allows.
struct AvailableForce {
  double peak = 0.0;    // N
  double step = 0.0;    // N, largest change from what is held
  double gain = 1.0;    // 0 ... 1: start ramp, fading
  bool fading = false;  // a fault: the peak falls with the gain, impacts end
  // give up the backlog, either sign: the loop stood still and held a force too long
  bool drop_backlog = false;
  double most_continuous = std::numeric_limits<double>::infinity();  // N, of the continuous force
};

class ForceLimiter {
 public:
  explicit ForceLimiter(double max_backlog_s) : max_backlog_s_(max_backlog_s) {}

  // The force to hold for the coming `period` seconds; `elapsed` is how long the last one was really held.
  // `requested` must be good().
  Vector3 tick(const RequestedForce& requested, const AvailableForce& available, double elapsed,
               double period);

  // The device has let go of all but this share of what it was told to hold.
  void let_go(double held) {
    continuous_ *= held;
    impact_ *= held;
  }

  bool limited() const { return limited_; }  // the last tick's force is not what was requested,
  bool at_peak() const { return at_peak_; }  // and the peak has cut it
  bool settled() const;                      // no backlog, and no impact is felt
  Vector3 held() const { return continuous_ + impact_; }
  const Vector3& continuous() const { return continuous_; }  // the part of it that is no impact
  const Vector3& backlog() const { return backlog_; }        // N s
  const Vector3& delivered() const { return delivered_; }
  const Vector3& lost() const { return lost_; }

 private:
  void drop(const Vector3& impulse);
  Vector3 catch_up(const Vector3& to_come, double step, double period) const;

  double max_backlog_s_;
  bool limited_ = false, at_peak_ = false, writing_off_ = false;
  double since_impact_ = 0.0;
  Vector3 continuous_ = Vector3::Zero(), impact_ = Vector3::Zero();  // as held now
  Vector3 backlog_ = Vector3::Zero(), delivered_ = Vector3::Zero(), lost_ = Vector3::Zero();
};

}  // namespace palpate::haptics
