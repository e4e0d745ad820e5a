#include "palpate/physics/deformable/solid.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/physics/deformable/hyperelastic.h"

namespace palpate::physics::deformable {
namespace {

double energy_of(Model model, const Solid::Point& point, const Matrix3& F) {
  return model == Model::linear ? linear_energy(point.shear, point.bulk, F)
                                : neo_hookean_energy(point.shear, point.bulk, F);
}

PointResponse response_of(Model model, const Solid::Point& point, const Matrix3& F) {
  return model == Model::linear ? linear_response(point.shear, point.bulk, F)
                                : neo_hookean_response(point.shear, point.bulk, F);
}

using ElementMatrix = Eigen::Matrix<double, 30, 30>;

// The lower triangle of blocks only.
void add_point(const Matrix9& tangent, const Solid::Point& point, ElementMatrix& K) {
  for (int b = 0; b < 10; ++b) {
    Eigen::Matrix<double, 9, 3> T = Eigen::Matrix<double, 9, 3>::Zero();
    for (int L = 0; L < 3; ++L) T += (point.volume * point.gradients(b, L)) * tangent.middleCols<3>(3 * L);
    for (int a = b; a < 10; ++a) {
      Matrix3 block = point.gradients(a, 0) * T.topRows<3>();
      block += point.gradients(a, 1) * T.middleRows<3>(3);
      block += point.gradients(a, 2) * T.bottomRows<3>();
      K.block<3, 3>(3 * a, 3 * b) += block;
    }
  }
}

struct WeighedPlace {
  Barycentric4 L;
  double weight;  // those of a quarter make 1
};

// Of a quadrature point's quarter of the element: what is nearer to its corner than to the others, which is a box with
// the corner, the middles of its edges and faces, and the element's. Gathered as a grid over that box, so that no
// place lies between two quarters and no order of the nodes counts.
std::vector<WeighedPlace> places_near_corner(int corner) {
  constexpr int kParts = 5;
  std::vector<WeighedPlace> places;
  double sum = 0.0;
  for (int n = 0; n < kParts * kParts * kParts; ++n) {
    const int row = n / kParts, layer = row / kParts;
    const auto middle = [](int k) { return (k % kParts + 0.5) / kParts; };
    const std::array<double, 3> x{middle(n), middle(row), middle(layer)};
    // With b_k = x_k L of the corner the box's sides are b = 1: L = 1/(1 + x1 + x2 + x3), b = x L; and volume goes as L^4.
    const double own = 1.0 / (1.0 + x[0] + x[1] + x[2]);
    WeighedPlace place{{}, own * own * own * own};
    for (int k = 0, other = 0; k < 4; ++k)
      place.L[static_cast<std::size_t>(k)] = k == corner ? own : own * x[static_cast<std::size_t>(other++)];
    sum += place.weight;
    places.push_back(place);
  }
  for (auto& place : places) place.weight /= sum;
  return places;
}

// Stiffness in parts of the matrix's at the four quadrature points. Where an inclusion's surface cuts an element
// the harmonic mean is taken: the element's few displacements cannot follow the jump of strain and would make it
// too stiff.
std::array<double, 4> ratios_of(const Material& material, const Eigen::Matrix<double, 10, 3>& X) {
  static const std::array<std::vector<WeighedPlace>, 4> places{places_near_corner(0), places_near_corner(1),
                                                               places_near_corner(2), places_near_corner(3)};
  std::array<double, 4> ratios;
  bool cut = false;
  const double first = material.ratio_at(X.row(0).transpose());
  for (int k = 1; k < 10; ++k) cut = cut || material.ratio_at(X.row(k).transpose()) != first;
  for (std::size_t q = 0; q < 4; ++q) {
    ratios[q] = material.ratio_at(X.transpose() * element_shape(element_rule()[q].L));
    cut = cut || ratios[q] != first;
  }
  if (!cut) return ratios;
  for (std::size_t q = 0; q < 4; ++q) {
    double sum = 0.0;
    for (const auto& [L, weight] : places[q])
      sum += weight / material.ratio_at(X.transpose() * element_shape(L));
    ratios[q] = 1.0 / sum;
  }
  return ratios;
}

}  // namespace

void FreeMotion::number() {
  count_ = 0;
  for (auto& equation : equations_)
    if (equation >= 0) equation = count_++;
}

Eigen::VectorXd FreeMotion::free_part(const Eigen::VectorXd& all) const {
  Eigen::VectorXd free(count_);
  for (int c = 0; c < all.size(); ++c)
    if (equation(c) >= 0) free[equation(c)] = all[c];
  return free;
}

void FreeMotion::add(const Eigen::VectorXd& free, double scale, Eigen::VectorXd& all) const {
  for (int c = 0; c < all.size(); ++c)
    if (equation(c) >= 0) all[c] += scale * free[equation(c)];
}

Solid::Solid(const TetMesh& mesh, const Material& material, Model model)
    : elements_(mesh.elements), model_(model) {
  points_.resize(mesh.elements.size());
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const auto X = places_of(mesh, mesh.elements[e]);
    const auto ratios = ratios_of(material, X);
    for (std::size_t q = 0; q < 4; ++q) {
      const auto& rule = element_rule()[q];
      const ElementGradients slopes = element_shape_derivatives(rule.L);
      const Matrix3 jacobian = X.transpose() * slopes;
      points_[e][q] = {slopes * jacobian.inverse(), rule.weight * jacobian.determinant() / 6.0,
                       ratios[q] * material.matrix.shear(), ratios[q] * material.matrix.bulk()};
    }
  }
}

Eigen::Matrix<double, 10, 3> Solid::displacements(std::size_t element, const Eigen::VectorXd& u) const {
  Eigen::Matrix<double, 10, 3> values;
  for (int k = 0; k < 10; ++k)
    values.row(k) = u.segment<3>(3 * elements_[element][static_cast<std::size_t>(k)]).transpose();
  return values;
}

Matrix3 Solid::gradient(const Point& point, const Eigen::Matrix<double, 10, 3>& u) {
  return Matrix3::Identity() + u.transpose() * point.gradients;
}

double Solid::energy(const Eigen::VectorXd& u) const {
  double sum = 0.0;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const auto local = displacements(e, u);
    for (const auto& point : points_[e])
      sum += point.volume * energy_of(model_, point, gradient(point, local));
    if (!std::isfinite(sum)) return std::numeric_limits<double>::infinity();
  }
  return sum;
}

Eigen::VectorXd Solid::forces(const Eigen::VectorXd& u) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(u.size());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const auto local = displacements(e, u);
    Eigen::Matrix<double, 10, 3> sum = Eigen::Matrix<double, 10, 3>::Zero();
    for (const auto& point : points_[e])
      sum += point.volume * point.gradients *
             response_of(model_, point, gradient(point, local)).stress.transpose();
    for (int k = 0; k < 10; ++k)
      f.segment<3>(3 * elements_[e][static_cast<std::size_t>(k)]) += sum.row(k).transpose();
  }
  return f;
}

void Solid::add_stiffness(const Eigen::VectorXd& u, const FreeMotion& motion, SymmetricMatrix& matrix) const {
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const auto local = displacements(e, u);
    ElementMatrix K = ElementMatrix::Zero();
    for (const auto& point : points_[e])
      add_point(response_of(model_, point, gradient(point, local)).tangent, point, K);
    K.triangularView<Eigen::StrictlyUpper>() = K.transpose();
    add_block(elements_[e].data(), K, motion, matrix);
  }
}

SymmetricMatrix stiffness_pattern(const TetMesh& mesh, const FreeMotion& motion) {
  std::vector<std::vector<int>> neighbours(mesh.nodes.size());  // of equal or higher number
  for (const auto& element : mesh.elements)
    for (const int a : element)
      for (const int b : element)
        if (b >= a) neighbours[static_cast<std::size_t>(a)].push_back(b);
  SymmetricMatrix matrix;
  matrix.size = motion.count();
  matrix.starts.assign(1, 0);
  for (std::size_t a = 0; a < neighbours.size(); ++a) {
    auto& others = neighbours[a];
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    for (int i = 0; i < 3; ++i) {
      const int column = motion.equation(3 * static_cast<int>(a) + i);
      if (column < 0) continue;
      for (const int b : others)
        for (int j = 0; j < 3; ++j)
          if (const int row = motion.equation(3 * b + j); row >= column) matrix.rows.push_back(row);
      matrix.starts.push_back(static_cast<int>(matrix.rows.size()));
    }
  }
  matrix.values.assign(matrix.rows.size(), 0.0);
  return matrix;
}

void add_block(const int* nodes, const Eigen::Ref<const Eigen::MatrixXd>& block, const FreeMotion& motion,
               SymmetricMatrix& matrix) {
  const int count = static_cast<int>(block.cols());
  for (int c = 0; c < count; ++c) {
    const int column = motion.equation(3 * nodes[c / 3] + c % 3);
    if (column < 0) continue;
    for (int r = 0; r < count; r += 3) {
      // The three equations of a node follow each other, so one search finds up to three places.
      int place = -1;
      for (int i = 0; i < 3; ++i) {
        const int row = motion.equation(3 * nodes[r / 3] + i);
        if (row < column) continue;
        place = place < 0 ? matrix.slot(row, column) : place + 1;
        matrix.values[static_cast<std::size_t>(place)] += block(r + i, c);
      }
    }
  }
}

}  // namespace palpate::physics::deformable
