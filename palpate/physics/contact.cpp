#include "palpate/physics/contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace palpate::physics {
namespace {

// Design B: phase wn T at which F vanishes, and the restitution there.
double phase_of_zero_force(double zeta) {
  return std::acos(2.0 * zeta * zeta - 1.0) / std::sqrt(1.0 - zeta * zeta);
}

}  // namespace

DampedContact::DampedContact(double mass, double restitution, double duration_s, Release release)
    : mass_(mass), restitution_(restitution), duration_(duration_s) {
  if (!(mass > 0.0) || !(duration_s > 0.0) || !(restitution > 0.0) || !(restitution <= 1.0)) {
    throw std::invalid_argument("contact: needs mass > 0, duration > 0 and 0 < restitution <= 1");
  }
  const double log_e = std::log(restitution);
  alpha_ = -log_e / duration_s;
  damping_ = 2.0 * mass * alpha_;
  if (release == Release::where_rest_length_is_back) {
    wd_ = std::numbers::pi / duration_s;
    stiffness_ = mass * (wd_ * wd_ + alpha_ * alpha_);
    return;
  }
  if (!(restitution > std::exp(-2.0))) {
    throw std::invalid_argument("contact: released at zero force a restitution must exceed exp(-2) = 0.135");
  }
  double low = 0.0, high = 1.0;  // e(zeta) = exp(-zeta wn T) falls from 1 to exp(-2)
  for (int i = 0; i < 200; ++i) {
    const double zeta = 0.5 * (low + high);
    (-zeta * phase_of_zero_force(zeta) > log_e ? low : high) = zeta;
  }
  const double wn = phase_of_zero_force(low) / duration_s;
  stiffness_ = mass * wn * wn;
  wd_ = std::sqrt(wn * wn - alpha_ * alpha_);
}

double DampedContact::damping_ratio() const { return damping_ / (2.0 * std::sqrt(stiffness_ * mass_)); }

double DampedContact::penetration(double t) const {
  t = std::clamp(t, 0.0, duration_);
  return std::exp(-alpha_ * t) * std::sin(wd_ * t) / wd_;
}

double DampedContact::velocity(double t) const {
  if (t <= 0.0) return 1.0;
  if (t >= duration_) return -restitution_;
  return std::exp(-alpha_ * t) * (std::cos(wd_ * t) - alpha_ / wd_ * std::sin(wd_ * t));
}

double DampedContact::force(double t) const {
  if (t < 0.0 || t > duration_) return 0.0;
  return stiffness_ * penetration(t) + damping_ * velocity(t);
}

double DampedContact::mean_force(double t0, double t1) const {
  if (!(t1 > t0)) return 0.0;
  return mass_ * (velocity(t0) - velocity(t1)) / (t1 - t0);
}

double DampedContact::peak_force() const {
  // F = -m x''; its derivative vanishes where x''' = 0: tan(wd t) = wd (wd^2 - 3 alpha^2) / (alpha (3 wd^2 -
  // alpha^2)).
  const double phase =
      std::atan2(wd_ * (wd_ * wd_ - 3.0 * alpha_ * alpha_), alpha_ * (3.0 * wd_ * wd_ - alpha_ * alpha_));
  const double at_touch = force(0.0);
  return phase > 0.0 ? std::max(at_touch, force(phase / wd_)) : at_touch;
}

double DampedContact::peak_penetration() const { return penetration(std::atan2(wd_, alpha_) / wd_); }

}  // namespace palpate::physics
