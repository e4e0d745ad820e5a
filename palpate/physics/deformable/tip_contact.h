// A rigid spherical tip with a shaft, pressed into a body's surface.
//
// Where a point of the displaced surface lies inside the tip it is pushed out along the tip's normal there, by a
// stiff spring per reference area:  E = integral of stiffness/2 penetration^2 dA.  The tip is a sphere; on its
// shaft's side of the centre it goes on as a cylinder of the same radius. SI, the body's frame. One thread at a
// time; it allocates. Source: Wriggers, Computational Contact Mechanics, chapter 6.
//
// Friction is Coulomb's, step by step: from hold() on a point's slip s along the tip is counted, and costs
// mu N f(|s|), quadratic up to a small slip and linear beyond it. N and the normal are those that weigh() found
// last, so that there is an energy to be searched; who searches weighs and searches again until N stays. What was
// not touched at hold() slips freely until the next one: its way to the tip was no slip. Source: Li et al. (2020),
// "Incremental potential contact", section 5 (lagged friction).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/physics/deformable/solid.h"

namespace palpate::physics::deformable {

struct RigidTip {
  Vector3 centre{0.0, 0.0, 0.0};
  Vector3 shaft{0.0, 0.0, 1.0};  // unit, away from the body
  double radius = 0.008;
};

// How deep a point lies in the tip, m, negative outside; the outward normal there; second derivatives of depth.
struct TipPenetration {
  double depth = 0.0;
  Vector3 normal{0.0, 0.0, -1.0};
  Matrix3 curvature = Matrix3::Zero();
};
TipPenetration penetration(const RigidTip& tip, const Vector3& place);

class TipContact {
 public:
  // Facets of the mesh that may be touched; stiffness in Pa/m. A facet is integrated in parts^2 triangles with
  // seven points each.
  TipContact(const TetMesh& mesh, const std::vector<int>& facets, double stiffness, int parts = 3);

  // Coulomb's coefficient, and the slip up to which a point counts as held, m. Without a call: no friction.
  void set_friction(double coefficient, double held_slip);
  // Slip is counted from here on; no friction until weigh().
  void hold(const RigidTip& tip, const Eigen::VectorXd& u);
  // What each point is pressed with now bounds its friction. The sum, N.
  double weigh(const RigidTip& tip, const Eigen::VectorXd& u);

  double energy(const RigidTip& tip, const Eigen::VectorXd& u) const;
  // The energy's gradient is added, 3 per node.
  void add_forces(const RigidTip& tip, const Eigen::VectorXd& u, Eigen::VectorXd& forces) const;
  // `curved`: with the part that comes of the tip's curvature, which is negative and, far from equilibrium, larger
  // than what holds the surface sideways. A share of it all can be taken.
  void add_stiffness(const RigidTip& tip, const Eigen::VectorXd& u, const FreeMotion& motion, bool curved,
                     SymmetricMatrix& matrix, double share = 1.0) const;

  // Of its facets, rising.
  const std::vector<int>& nodes() const { return nodes_; }

  struct State {
    Vector3 force{0.0, 0.0, 0.0};  // of the body on the tip, N
    double radius = 0.0;  // m: how far from the axis a point in contact lay before it was displaced, at most
  };
  State state(const RigidTip& tip, const Eigen::VectorXd& u) const;

 private:
  struct Point {
    Eigen::Matrix<double, 6, 1> shape;
    double area;  // m^2
  };
  struct Grip {  // of a point: where it was from the tip's centre, the tip's normal there, mu N
    Vector3 from{0.0, 0.0, 0.0}, normal{0.0, 0.0, 1.0};
    bool touched = false;
    double limit = 0.0;
  };
  struct Facet {
    QuadraticFacet nodes;
    Eigen::Matrix<double, 6, 3> places;
    std::vector<Point> points;
    std::vector<Grip> grips;  // as many; none without friction
    bool gripped = false;
  };
  class Blocks;
  template <typename Visit>  // (facet, point, penetration, reference place) of each point in contact
  void each_in_contact(const RigidTip& tip, const Eigen::VectorXd& u, const Visit& visit) const;
  template <typename Visit>  // (facet, point, grip, slip) of each point with friction
  void each_gripped(const RigidTip& tip, const Eigen::VectorXd& u, const Visit& visit) const;
  static Eigen::Matrix<double, 6, 3> displaced(const Facet& facet, const Eigen::VectorXd& u);
  Vector3 friction_on(const Grip& grip, const Vector3& slip) const;  // by which the tip holds the surface

  std::vector<Facet> facets_;
  std::vector<int> nodes_;
  double stiffness_, friction_ = 0.0, held_slip_ = 0.0;
};

}  // namespace palpate::physics::deformable
