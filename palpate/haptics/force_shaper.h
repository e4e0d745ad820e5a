// Makes of any asked force one that a device can follow: peak and slew kept together, impulse not lost.
//
// Two kinds of force come in: a sustained one, which is limited as it is, and blows, whose IMPULSE counts:
// where a limit cuts a blow's force, what is missing is owed and paid by holding the force longer, so that
// the hand receives the whole impulse. What cannot be paid (fault, start ramp, longer than `longest_debt_s`)
// is lost and counted; at any moment, to rounding,
//   asked = delivered + owed + lost          N s, of all blows so far
// N, s, any one frame. Haptic thread alone; does not allocate, lock or throw. docs/theory/forces.md.
#pragma once

#include "palpate/geometry/so3.h"
#include "palpate/haptics/force_limits.h"

namespace palpate {

struct AskedForce {
  Vector3 sustained = Vector3::Zero();     // N
  Vector3 blow = Vector3::Zero();          // N, mean over the coming tick
  Vector3 blow_to_come = Vector3::Zero();  // N s, impulse of the blows under way after the coming tick
  bool blow_active = false;

  // Numbers, and none that no arm could ever be asked for.
  bool good() const {
    constexpr double kMost = 1e6;
    const auto fine = [](const Vector3& v) { return v.cwiseAbs().maxCoeff() < kMost && v.allFinite(); };
    return fine(sustained) && fine(blow) && fine(blow_to_come);
  }
};

// What this tick allows.
struct ForceRoom {
  double peak = 0.0;    // N
  double step = 0.0;    // N, largest change from what is held
  double gain = 1.0;    // 0 ... 1: start ramp, fading
  bool fading = false;  // a fault: the peak falls with the gain, blows end
  bool forgive =
      false;  // give up what is owed now, either sign: the loop stood still and held a force too long
};

class ForceShaper {
 public:
  explicit ForceShaper(double longest_debt_s) : longest_debt_s_(longest_debt_s) {}

  // The force to hold for the coming `period` seconds; `elapsed` is how long the last one was really held.
  // `asked` must be good().
  Vector3 tick(const AskedForce& asked, const ForceRoom& room, double elapsed, double period);

  bool limited() const { return limited_; }  // the last tick's force is not what was asked for,
  bool at_peak() const { return at_peak_; }  // and the peak has cut it
  bool settled() const;                      // no blow is being paid
  Vector3 held() const { return sustained_ + blow_; }
  const Vector3& sustained() const { return sustained_; }  // the part of it that is no blow
  const Vector3& owed() const { return owed_; }            // N s
  const Vector3& delivered() const { return delivered_; }
  const Vector3& lost() const { return lost_; }

 private:
  void lose(const Vector3& impulse);
  Vector3 payment(const Vector3& to_come, double step, double period) const;

  double longest_debt_s_;
  bool limited_ = false, at_peak_ = false, writing_off_ = false;
  double since_blow_ = 0.0;
  Vector3 sustained_ = Vector3::Zero(), blow_ = Vector3::Zero();  // as held now
  Vector3 owed_ = Vector3::Zero(), delivered_ = Vector3::Zero(), lost_ = Vector3::Zero();
};

}  // namespace palpate
