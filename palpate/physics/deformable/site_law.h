// Force of a spherical tip over depth at one place of a body's surface, in closed form.
//
// A half-space of the place's own matter in series with what the rest of the body adds to or takes from it, its
// residual compliance c(a) at a contact of radius a:
//   F0(delta) = 4/3 E* sqrt(Q) delta^(3/2) (1 - k delta/R),   a = sqrt(Q delta) (1 - 0.1 delta/R),   1/Q = 1/R + H
//   d = delta + F c(a) + F^2/2 dc/dF,   c(a) = c_homogeneous + s(d) c_inclusions(a)
// H is the surface's mean curvature, positive where it bulges (Johnson, Contact Mechanics, section 4.2, for two spheres).
// The last term of d makes the force of fixed s the derivative of an energy. k corrects Hertz for finite strain;
// s = 1 + (0.187/t + 0.26/R) d lets what an inclusion adds grow with depth d, with the layer t above it, up to d = 1.6 t,
// as deep as it has been tried. k and s are fitted to neo-Hookean solutions, docs/theory/deformable.md. SI. Values; force()
// and energy() do not allocate.
#pragma once

#include <limits>
#include <vector>

#include "palpate/physics/deformable/elasticity.h"

namespace palpate::physics::deformable {

// k of a Poisson's ratio.
double finite_strain_softening(double poisson);
// The contact's radius before it was displaced, of a tip that is `depth` deep in a half-space.
double footprint(double radius, double depth, double curvature = 0.0);

struct SiteLaw {
  Elastic matter;
  double radius = 0.008;
  double curvature = 0.0;          // 1/m, of the surface, more than -1/radius
  double homogeneous = 0.0;        // m/N, residual compliance without inclusions
  std::vector<double> footprints;  // m, rising
  std::vector<double> inclusions;  // m/N at these: what inclusions change
  // m, above the nearest inclusion where that is thinnest, wherever beside it the site lies.
  double layer = std::numeric_limits<double>::infinity();

  double force(double depth) const;  // N
  // J; the force integrated over depth.
  double energy(double depth) const;
  double contact_radius(double depth) const;

 private:
  double half_space_depth(double depth) const;
  double whole_depth(double delta, double growth) const;
  double compliance(double a, double growth, double& slope) const;
};

}  // namespace palpate::physics::deformable
