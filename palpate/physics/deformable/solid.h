// A meshed body with its matter: stored energy, forces and stiffness for given displacements of its nodes.
//
// Displacements and forces are vectors of 3 numbers per node, x y z, of all nodes; metres, newtons. A system of
// equations knows which of them are free. Four quadrature points an element, each with its own stiffness, so that
// an inclusion need not follow the mesh. Four points keep quadratic tetrahedra from locking at Poisson's ratios up
// to 0.49. One thread at a time; it allocates.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "palpate/physics/deformable/elasticity.h"
#include "palpate/physics/deformable/quadratic_shape.h"
#include "palpate/physics/deformable/sparse_solver.h"
#include "palpate/physics/deformable/tet_mesh.h"

namespace palpate::physics::deformable {

// Which components of which nodes may move.
class FreeMotion {
 public:
  explicit FreeMotion(const TetMesh& mesh) : equations_(3 * mesh.nodes.size(), 0) {}
  void hold(int node, int axis) { equations_[static_cast<std::size_t>(3 * node + axis)] = -1; }
  void hold(int node) {
    for (int axis = 0; axis < 3; ++axis) hold(node, axis);
  }
  // To be called after the last hold().
  void number();
  int count() const { return count_; }
  // The equation of component 3 node + axis; -1 where it is held.
  int equation(int component) const { return equations_[static_cast<std::size_t>(component)]; }
  Eigen::VectorXd free_part(const Eigen::VectorXd& all) const;
  // all += scale * free.
  void add(const Eigen::VectorXd& free, double scale, Eigen::VectorXd& all) const;

 private:
  std::vector<int> equations_;
  int count_ = 0;
};

class Solid {
 public:
  Solid(const TetMesh& mesh, const Material& material, Model model);

  double energy(const Eigen::VectorXd& u) const;  // J; infinite where an element is turned inside out
  // Forces of the nodes on the matter that hold it in this state: the energy's gradient.
  Eigen::VectorXd forces(const Eigen::VectorXd& u) const;
  // The energy's second derivatives among free components are added to a matrix from stiffness_pattern().
  void add_stiffness(const Eigen::VectorXd& u, const FreeMotion& motion, SymmetricMatrix& matrix) const;

  struct Point {
    ElementGradients gradients;  // of the shape functions by place, 1/m
    double volume, shear, bulk;  // m^3, Pa
  };
  const std::vector<std::array<Point, 4>>& points() const { return points_; }
  // The deformation gradient there.
  static Matrix3 gradient(const Point& point, const Eigen::Matrix<double, 10, 3>& u);

 private:
  Eigen::Matrix<double, 10, 3> displacements(std::size_t element, const Eigen::VectorXd& u) const;

  std::vector<QuadraticElement> elements_;
  std::vector<std::array<Point, 4>> points_;
  Model model_;
};

// Zero, with a place for each pair of free components that share an element.
SymmetricMatrix stiffness_pattern(const TetMesh& mesh, const FreeMotion& motion);

// Adds a dense symmetric block of some nodes, three rows each.
void add_block(const int* nodes, const Eigen::Ref<const Eigen::MatrixXd>& block, const FreeMotion& motion,
               SymmetricMatrix& matrix);

}  // namespace palpate::physics::deformable
