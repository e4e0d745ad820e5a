// What stands between any computed force and the motors.
//
// Two kinds of force come in: a sustained one, which is limited as it is, and blows, whose IMPULSE counts:
// where a limit cuts a blow's force, what is missing is owed and paid by holding the force longer, so that
// the hand receives the whole impulse; what cannot be paid (fault, start ramp, longer than `longest_debt_s`)
// is lost and counted. Forces fade, never jump. N, s, any one frame. Used by the haptic thread alone; tick()
// does not allocate, lock or throw. Defaults: makers' 8.5 N peak and 1.4 N continuous of a Premium 1.5; slew
// below the 4 N per tick at which such devices switch off; docs/theory/contact.md.
#pragma once

#include <cstdint>

#include "palpate/geometry/so3.h"

namespace palpate {

struct ForceLimits {
  double peak_n = 8.5;
  double continuous_n = 1.4;  // root mean square over `continuous_s`; above it the peak falls to this value
  double continuous_s = 1.0;
  double slew_n_s = 3000.0;        // 3 N per millisecond
  double start_ramp_s = 1.0;       // from 0 to full strength, also after a fault
  double fade_s = 0.020;           // from full strength to 0 in a fault
  double max_tip_speed_m_s = 3.0;  // faster: off until rearm()
  double stale_s = 0.005;          // no fresh input for this long: fade
  double longest_debt_s = 0.100;   // a blow's impulse still owed this long after it ended is given up
};

enum class ForceFault : std::uint8_t { none, stale_input, not_finite, overspeed };

struct AskedForce {
  Vector3 sustained = Vector3::Zero();     // N
  Vector3 blow = Vector3::Zero();          // N, mean over the coming tick
  Vector3 blow_to_come = Vector3::Zero();  // N s, impulse of the blows under way after the coming tick
  bool blow_active = false;
  double tip_speed = 0.0;    // m/s
  double input_age_s = 0.0;  // since the last fresh input
};

class ForceLimiter {
 public:
  explicit ForceLimiter(const ForceLimits& limits = {});

  // The force to hold for the coming `period` seconds; `elapsed` is how long the last one was really held.
  Vector3 tick(const AskedForce& asked, double elapsed, double period);
  void rearm();

  ForceFault fault() const { return fault_; }
  double gain() const { return gain_; }                    // 0 = off, 1 = full strength
  bool limited() const { return limited_; }                // the last tick's force is not what was asked for
  const Vector3& owed() const { return owed_; }            // N s
  bool settled() const;                                    // no blow is being paid
  const Vector3& delivered() const { return delivered_; }  // N s, of blows, all time
  const ForceLimits& limits() const { return limits_; }

 private:
  Vector3 pay(const Vector3& to_come, double room, double step, double period) const;

  ForceLimits limits_;
  ForceFault fault_ = ForceFault::none;
  bool overspeed_ = false, limited_ = false;
  double gain_ = 0.0, mean_square_ = 0.0, since_blow_ = 0.0;
  Vector3 sustained_ = Vector3::Zero(), blow_ = Vector3::Zero();  // as held now
  Vector3 owed_ = Vector3::Zero(), delivered_ = Vector3::Zero();
};

}  // namespace palpate
