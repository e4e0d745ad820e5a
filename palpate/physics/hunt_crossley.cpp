#include "palpate/physics/hunt_crossley.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate::physics {
namespace {

constexpr double kLeastRestitution = 0.05;
// a = c v: below, the difference of the two sides of the conserved quantity is lost in rounding.
constexpr double kSeries = 1e-3;

// x^n for x >= 0; a ball that has just left presses on nothing.
double raised(double x, double n) {
  if (x <= 0.0) return 0.0;
  if (n == 1.0) return x;
  if (n == 1.5) return x * std::sqrt(x);
  return std::pow(x, n);
}

// Restitution at a = c v.
double restitution_of_damping(double a) {
  if (a < kSeries) return 1.0 - 2.0 / 3.0 * a + 4.0 / 9.0 * a * a;
  const double target = a - std::log1p(a);
  double low = 0.0, high = std::min(1.0, 1.0 / a);
  for (int i = 0; i < 100; ++i) {
    const double e = 0.5 * (low + high);
    (-a * e - std::log1p(-a * e) < target ? low : high) = e;
  }
  return 0.5 * (low + high);
}

// Lengths in (m v^2 / k)^(1 / (n + 1)), speeds in v: x'' = -x^n (1 + a x').
struct Unitless {
  double x = 0.0, v = 1.0;
  void step(double h, double a, double n) {
    const auto f = [&](double at, double speed) { return -raised(at, n) * (1.0 + a * speed); };
    const double k1 = f(x, v), k2 = f(x + 0.5 * h * v, v + 0.5 * h * k1);
    const double k3 = f(x + 0.5 * h * (v + 0.5 * h * k1), v + 0.5 * h * k2);
    const double k4 = f(x + h * (v + 0.5 * h * k2), v + h * k3);
    x += h * (v + h * (k1 + k2 + k3) / 6.0);
    v += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
  }
};

// a = c v that leaves with this restitution: where the two sides of the conserved quantity agree.
double damping_of_restitution(double e) {
  const double lost = 1.0 - e;
  if (lost <= 0.0) return 0.0;
  // The series above turned round, as far as it is used there.
  if (const double root = 1.0 - 4.0 * lost; root > 0.0) {
    const double a = 0.75 * (1.0 - std::sqrt(root));
    if (a < kSeries) return a;
  }
  double low = 0.5 * kSeries, high = 1.0 / e;
  for (int i = 0; i < 100; ++i) {
    const double a = 0.5 * (low + high);
    (a - std::log1p(a) > -a * e - std::log1p(-a * e) ? low : high) = a;
  }
  return 0.5 * (low + high);
}

double unitless_duration(double a, double n, int steps) {
  constexpr double kStep = 0.05;
  Unitless ball;
  double t = 0.0;
  do {
    ball.step(kStep, a, n);
    t += kStep;
  } while (ball.x > 0.0);
  t += ball.x / -ball.v;  // free beyond the surface: exact
  Unitless again;         // the same with the steps that will be kept
  for (int k = 0; k < steps; ++k) again.step(t / steps, a, n);
  return t + again.x / -again.v;
}

void check_contact(double mass, double restitution, double duration_s, double speed, double exponent) {
  if (!(mass > 0.0) || !(duration_s > 0.0) || !(speed > 0.0) || !(restitution >= kLeastRestitution) ||
      !(restitution <= 1.0) || !(exponent >= 1.0) || !(exponent <= 3.0)) {
    throw std::invalid_argument(
        "contact: Hunt-Crossley needs mass, duration and speed > 0, 0.05 <= restitution <= 1 and 1 <= "
        "exponent <= 3");
  }
}

}  // namespace

HuntCrossley::HuntCrossley(double mass, double restitution, double duration_s, double speed, double exponent)
    : mass_(mass), exponent_(exponent) {
  check_contact(mass, restitution, duration_s, speed, exponent);
  const double a = damping_of_restitution(restitution);
  damping_ = a / speed;
  const double length = duration_s * speed / unitless_duration(a, exponent, HuntCrossleyContact::kSteps);
  stiffness_ = mass * speed * speed / std::pow(length, exponent + 1.0);
}

double HuntCrossley::restitution(double speed) const { return restitution_of_damping(damping_ * speed); }

HuntCrossleyContact HuntCrossley::contact(double speed) const {
  const double a = damping_ * speed;
  const double length = std::pow(mass_ * speed * speed / stiffness_, 1.0 / (exponent_ + 1.0));
  const double t = unitless_duration(a, exponent_, HuntCrossleyContact::kSteps);
  return {mass_, restitution_of_damping(a), t * length / speed, speed, exponent_, a, t};
}

HuntCrossleyContact::HuntCrossleyContact(double mass, double restitution, double duration_s, double speed,
                                         double exponent) {
  check_contact(mass, restitution, duration_s, speed, exponent);
  const double a = damping_of_restitution(restitution);
  *this = {mass, restitution, duration_s, speed, exponent, a, unitless_duration(a, exponent, kSteps)};
}

// `t`: the unitless duration at a = c v.
HuntCrossleyContact::HuntCrossleyContact(double mass, double restitution, double duration_s, double speed,
                                         double exponent, double a, double t)
    : mass_(mass),
      speed_(speed),
      damping_(a / speed),
      exponent_(exponent),
      duration_(duration_s),
      restitution_(restitution) {
  const double length = duration_s * speed / t;
  stiffness_ = mass * speed * speed / std::pow(length, exponent + 1.0);
  Unitless ball;
  for (auto& node : nodes_) {
    node = {length * ball.x, speed * ball.v};
    ball.step(t / kSteps, a, exponent);
  }
  nodes_.back() = {0.0, -restitution * speed};  // what integration missed by 1e-7
}

HuntCrossleyContact::Node HuntCrossleyContact::at(double t) const {
  const double s = std::clamp(t / duration_, 0.0, 1.0) * kSteps;
  const int k = std::min(static_cast<int>(s), kSteps - 1);
  const double u = s - k, h = duration_ / kSteps;
  const Node &a = nodes_[static_cast<std::size_t>(k)], &b = nodes_[static_cast<std::size_t>(k + 1)];
  const auto acceleration = [&](const Node& node) {
    return -stiffness_ * raised(node.x, exponent_) * (1.0 + damping_ * node.v) / mass_;
  };
  // Cubic Hermite: value and slope at both nodes.
  const double u2 = u * u, u3 = u2 * u;
  const double f0 = 2 * u3 - 3 * u2 + 1, f1 = u3 - 2 * u2 + u, f2 = -2 * u3 + 3 * u2, f3 = u3 - u2;
  return {f0 * a.x + f1 * h * a.v + f2 * b.x + f3 * h * b.v,
          f0 * a.v + f1 * h * acceleration(a) + f2 * b.v + f3 * h * acceleration(b)};
}

double HuntCrossleyContact::penetration(double t) const { return std::max(0.0, at(t).x); }

double HuntCrossleyContact::velocity(double t) const {
  if (t <= 0.0) return speed_;
  if (t >= duration_) return -restitution_ * speed_;
  return at(t).v;
}

double HuntCrossleyContact::force(double t) const {
  if (t < 0.0 || t > duration_) return 0.0;
  const Node node = at(t);
  return stiffness_ * raised(node.x, exponent_) * (1.0 + damping_ * node.v);
}

double HuntCrossleyContact::mean_force(double t0, double t1) const {
  if (!(t1 > t0)) return 0.0;
  return mass_ * (velocity(t0) - velocity(t1)) / (t1 - t0);
}

}  // namespace palpate::physics
