#include "palpate/physics/deformable/half_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::physics::deformable {

double hertz_force(const Elastic& matter, double radius, double depth) {
  return depth > 0.0 ? 4.0 / 3.0 * matter.plane_strain() * std::sqrt(radius * depth) * depth : 0.0;
}

double hertz_contact_radius(double radius, double depth) { return std::sqrt(radius * std::max(depth, 0.0)); }

double bonded_layer_factor(double poisson, double radius, double depth, double thickness) {
  using std::numbers::pi;
  const double nu = poisson, chi = hertz_contact_radius(radius, depth) / thickness;
  const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
  const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1.0 - nu);
  const double a3 = a * a * a;
  return 1.0 + chi * (-2.0 * a / pi +
                      chi * (4.0 * a * a / (pi * pi) +
                             chi * (-8.0 / std::pow(pi, 3) * (a3 + 4.0 * pi * pi / 15.0 * b) +
                                    chi * 16.0 * a / std::pow(pi, 4) * (a3 + 3.0 * pi * pi / 5.0 * b))));
}

}  // namespace palpate::physics::deformable
