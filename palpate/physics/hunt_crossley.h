// A ball's contact with a surface that stiffens as it is pressed and damps by how deep it is pressed.
//
//   F = k x^n (1 + c x'),   m x'' = -F,   x(0) = 0,  x'(0) = v        x penetration, v approach speed
// No force at the first touch, none that pulls, and a restitution that falls with speed, as real balls' does:
// with w = c x' the motion keeps
//   w - ln(1 + w) + (c^2 k / m) x^(n + 1) / (n + 1),   so   a - ln(1 + a) = -a e - ln(1 - a e),  a = c v,
// and the duration goes as v^((1 - n) / (1 + n)) T(a). Time is integrated numerically (Runge-Kutta 4), the
// restitution is exact, and so is the impulse m (1 + e) v. SI. Values; contact() allocates nothing and takes
// some tens of microseconds. Source: Hunt and Crossley (1975), "Coefficient of restitution interpreted as
// damping in vibroimpact"; docs/theory/contact.md.
#pragma once

#include <array>

namespace palpate::physics {

// One impact: how deep, how fast, how hard, at each moment of it.
class HuntCrossleyContact {
 public:
  HuntCrossleyContact() = default;
  // The one that has this restitution and duration at this speed: for who knows of an impact no more than
  // these. Throws as HuntCrossley does.
  HuntCrossleyContact(double mass, double restitution, double duration_s, double speed,
                      double exponent = 1.5);
  double mass() const { return mass_; }
  double speed() const { return speed_; }  // of approach, m/s
  double duration() const { return duration_; }
  double restitution() const { return restitution_; }
  // t in [0, duration], clamped to it.
  double penetration(double t) const;  // m
  double velocity(double t) const;     // m/s, positive inwards
  double force(double t) const;        // N, pushes apart; 0 outside the contact
  // Mean force over [t0, t1], any part of which may lie outside the contact; sums to m (1 + e) v exactly.
  double mean_force(double t0, double t1) const;

 private:
  friend class HuntCrossley;
  HuntCrossleyContact(double mass, double restitution, double duration_s, double speed, double exponent,
                      double a, double t);
  static constexpr int kSteps = 256;
  struct Node {
    double x, v;
  };
  Node at(double t) const;  // cubic between nodes

  double mass_ = 0.0, speed_ = 0.0, stiffness_ = 0.0, damping_ = 0.0, exponent_ = 1.5;
  double duration_ = 0.0, restitution_ = 1.0;
  std::array<Node, kSteps + 1> nodes_{};
};

class HuntCrossley {
 public:
  // Spring and damper that give this restitution and duration at this approach speed. Throws
  // std::invalid_argument outside 0.05 <= restitution <= 1, 1 <= exponent <= 3, and for a mass, duration or
  // speed that is not positive. Exponent 3/2: Hertz (1882).
  HuntCrossley(double mass, double restitution, double duration_s, double speed, double exponent = 1.5);

  double stiffness() const { return stiffness_; }  // N/m^n
  double damping() const { return damping_; }      // c, s/m
  double restitution(double speed) const;
  HuntCrossleyContact contact(double speed) const;  // speed > 0

 private:
  double mass_, exponent_, stiffness_ = 0.0, damping_ = 0.0;
};

}  // namespace palpate::physics
