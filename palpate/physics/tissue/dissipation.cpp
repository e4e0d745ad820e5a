#include "palpate/physics/tissue/dissipation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate::physics::tissue {

void check_dissipation(const DissipationSettings& s) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!within(s.damping_n_s_m, 0.0, 5.0))
    throw std::invalid_argument(fmt::format("tissue: damping {} N s/m; 0 to 5 is expected", s.damping_n_s_m));
  if (!within(s.relaxation_s, 2e-4, 10.0) || !within(s.fade_m, 1e-6, 0.1) ||
      !within(s.most_viscous_n, 0.0, 10.0))
    throw std::invalid_argument(
        fmt::format("tissue: relaxation {} s, fade {} m, viscous force {} N; 0.0002 to 10, 0.000001 to 0.1 "
                    "and 0 to 10 are expected",
                    s.relaxation_s, s.fade_m, s.most_viscous_n));
  if (!within(s.friction, 0.0, 2.0) || !within(s.poisson, 0.0, 0.5))
    throw std::invalid_argument(fmt::format(
        "tissue: friction {}, Poisson's ratio {}; 0 to 2 and 0 to 0.5 are expected", s.friction, s.poisson));
}

namespace {

const DissipationSettings& checked_dissipation(const DissipationSettings& settings) {
  check_dissipation(settings);
  return settings;
}

}  // namespace

double viscous_step_bound(const DissipationSettings& s, double step, double dt) {
  if (s.damping_n_s_m == 0.0) return 0.0;
  const double spring = s.damping_n_s_m / s.relaxation_s;
  return spring * step / (1.0 + dt * spring / s.damping_n_s_m);
}

Dissipation::Dissipation(const DissipationSettings& settings)
    : settings_(checked_dissipation(settings)),
      spring_(settings.damping_n_s_m / settings.relaxation_s),
      ratio_(2.0 * (1.0 - settings.poisson) / (2.0 - settings.poisson)) {}

void Dissipation::reset() {
  arm_.setZero();
  stretch_.setZero();
  shear_ = 0.0;
  sliding_ = false;
}

double Dissipation::stored() const {
  return 0.5 * spring_ * arm_.squaredNorm() + 0.5 * shear_ * stretch_.squaredNorm();
}

double Dissipation::dashpot(const TipEnergy& now) const {
  return settings_.damping_n_s_m * std::min(1.0, now.depth / settings_.fade_m);
}

// Shortens the arm along the normal until it neither pulls more than the body presses nor presses more than it may.
void Dissipation::limit_normal(const Vector3& normal, double pressed) {
  const double along = normal.dot(arm_);
  const double allowed = std::clamp(along, -settings_.most_viscous_n / spring_,
                                    std::min(pressed, settings_.most_viscous_n) / spring_);
  arm_ += (allowed - along) * normal;
}

void Dissipation::stretch(const TipEnergy& now, const Vector3& moved) {
  stretch_ += moved;
  stretch_ -= now.normal.dot(stretch_) * now.normal;
  const double shear = ratio_ * now.tangent;
  if (shear > shear_ && shear_ > 0.0) stretch_ *= shear_ / shear;
  shear_ = shear;
}

Vector3 Dissipation::step(const TipEnergy& now, const Vector3& moved, double dt) {
  if (!(now.depth > 0.0) || now.normal.isZero(0.0)) {
    reset();
    return Vector3::Zero();
  }
  const double b = dashpot(now);
  arm_ = b > 0.0 && spring_ > 0.0 ? Vector3((arm_ + moved) / (1.0 + dt * spring_ / b))
                                  : Vector3(Vector3::Zero());
  const double pressed = std::max(0.0, now.normal.dot(now.force));
  limit_normal(now.normal, pressed);
  stretch(now, moved);

  const Vector3 across = -spring_ * (arm_ - now.normal.dot(arm_) * now.normal) - shear_ * stretch_;
  const double along = -spring_ * now.normal.dot(arm_);
  const double limit = settings_.friction * std::max(0.0, pressed + along), asked = across.norm();
  sliding_ = asked > limit;
  if (!sliding_) return along * now.normal + across;
  const double share = limit / asked;
  stretch_ *= share;
  arm_ = share * arm_ + (1.0 - share) * now.normal.dot(arm_) * now.normal;
  return along * now.normal + share * across;
}

}  // namespace palpate::physics::tissue
