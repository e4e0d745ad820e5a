// A ball's contact with an elastic surface as a damped mass on a spring, in closed form.
//
//   m x'' + b x' + k x = 0,  x(0) = 0,  x'(0) = v        x penetration, v approach speed
//   alpha = b / 2m,  wd = sqrt(k/m - alpha^2)
//   x = (v/wd) exp(-alpha t) sin wd t        force on the hand side: F = b x' + k x = -m x''
// Design A (the paper's) ends where x = 0 again; it pulls during the last moments. Design B ends where F = 0:
// nothing sticks, and what is left of the penetration relaxes without the ball. Both leave with exactly -e v
// after exactly T and hand over exactly m (1 + e) v. Linear in v: everything below is for v = 1 m/s. Pure
// values, safe from any thread. Sources: the 2006 paper, section 6.4; docs/theory/contact.md with the tables
// the tests check.
#pragma once

namespace palpate::physics {

enum class Release { where_rest_length_is_back, where_force_is_zero };  // designs A and B

class DampedContact {
 public:
  // Spring and damper that give this restitution and duration. Throws std::invalid_argument outside 0 < e <=
  // 1 (design B: exp(-2) < e, where the motion stays a damped oscillation), mass > 0, duration > 0.
  DampedContact(double mass, double restitution, double duration_s, Release release);

  double mass() const { return mass_; }
  double restitution() const { return restitution_; }
  double duration() const { return duration_; }
  double stiffness() const { return stiffness_; }  // N/m
  double damping() const { return damping_; }      // N s/m
  double damping_ratio() const;

  // Per 1 m/s of approach speed, t in [0, duration], clamped to it.
  double penetration(double t) const;  // m
  double velocity(double t) const;     // m/s, positive inwards
  double force(double t) const;        // N, positive = pushes apart; 0 outside the contact
  // Mean force over [t0, t1], any part of which may lie outside the contact: m (x'(t0) - x'(t1)) / (t1 - t0).
  // However a contact is cut into ticks, the sum of force times length is m (1 + e) exactly.
  double mean_force(double t0, double t1) const;
  double peak_force() const;        // N
  double peak_penetration() const;  // m

 private:
  double mass_, restitution_, duration_, stiffness_ = 0.0, damping_ = 0.0, alpha_ = 0.0, wd_ = 0.0;
};

}  // namespace palpate::physics
