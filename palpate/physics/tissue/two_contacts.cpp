#include "palpate/physics/tissue/two_contacts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::physics::tissue {
namespace {

constexpr int kSteps = 8;  // of Newton's method: to rounding where it converges at all

// A contact at a fixed place: kappa delta^2.5 and its derivatives by delta.
struct Own {
  FieldSample depth, kappa;
  double per_kappa(double delta) const { return delta * delta * std::sqrt(delta); }
  double energy(double delta) const { return kappa.value * per_kappa(delta); }
  double force(double delta) const { return 2.5 * kappa.value * delta * std::sqrt(delta); }
  double tangent(double delta) const { return 3.75 * kappa.value * std::sqrt(delta); }
};

Own own_at(const TipField& field, const Vector3& p) {
  if (!field.fields().lattice().covers(p)) return {};
  const auto [depth, kappa] = field.fields().sample(p);
  if (!(depth.value > 0.0 && kappa.value > 0.0)) return {};
  return {depth, kappa};
}

}  // namespace

MutualCompliance half_space_compliance(const Vector3& first, const Vector3& second, double young,
                                       double poisson, double closest) {
  const Vector3 apart = first - second;
  const double r = std::sqrt(apart.squaredNorm() + closest * closest);
  const double value = (1.0 - poisson * poisson) / (std::numbers::pi * young * r);
  return {value, -value / (r * r) * apart};
}

TwoForces two_contacts(const TipField& field_1, const Vector3& first, const TipField& field_2,
                       const Vector3& second, const MutualCompliance& mutual) {
  const Own a = own_at(field_1, first), b = own_at(field_2, second);
  const double d1 = a.depth.value, d2 = b.depth.value;
  TwoForces result;
  if (!(d1 > 0.0 || d2 > 0.0)) return result;
  // One after the other, each by Newton's rule for its own depth, from above: forces rise with depth.
  double x = std::max(0.0, d1), y = std::max(0.0, d2);
  for (int i = 0; i < kSteps; ++i) {
    const double off_x = d1 - mutual.value * b.force(y) - x, off_y = d2 - mutual.value * a.force(x) - y;
    const double slope_x = mutual.value * b.tangent(y), slope_y = mutual.value * a.tangent(x);
    const double determinant = 1.0 - slope_x * slope_y;
    // Where each gives way more than the other resists, simply one after the other.
    const bool newton = determinant > 0.1;
    x = std::clamp(newton ? x + (off_x - slope_x * off_y) / determinant : x + 0.5 * off_x, 0.0,
                   std::max(0.0, d1));
    y = std::clamp(newton ? y + (off_y - slope_y * off_x) / determinant : y + 0.5 * off_y, 0.0,
                   std::max(0.0, d2));
  }
  const double f1 = a.force(x), f2 = b.force(y);
  result.first_depth = x;
  result.second_depth = y;
  result.energy = a.energy(x) + b.energy(y) + mutual.value * f1 * f2;
  // What stands in the energy explicitly counts once: the two depths are where it does not change with them.
  const double shared = f1 * f2;
  result.first = -(f1 * a.depth.gradient + a.per_kappa(x) * a.kappa.gradient - shared * mutual.gradient);
  result.second = -(f2 * b.depth.gradient + b.per_kappa(y) * b.kappa.gradient + shared * mutual.gradient);
  return result;
}

}  // namespace palpate::physics::tissue
