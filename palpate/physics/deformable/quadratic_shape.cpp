#include "palpate/physics/deformable/quadratic_shape.h"

#include <cmath>
#include <vector>

namespace palpate::physics::deformable {
namespace {

// dL_k / d(L_1, L_2, ...): row k of corner k.
template <int kDimensions>
double slope(int corner, int direction) {
  if (corner == 0) return -1.0;
  return corner == direction + 1 ? 1.0 : 0.0;
}

constexpr std::array<std::array<int, 2>, 3> kFacetEdges{{{0, 1}, {1, 2}, {2, 0}}};

// Triangle (i, j, upright or not) of the parts^2 equal ones.
std::vector<std::array<Barycentric3, 3>> parts_of_facet(int parts) {
  const auto corner = [parts](int i, int j) {
    return Barycentric3{1.0 - static_cast<double>(i + j) / parts, static_cast<double>(i) / parts,
                        static_cast<double>(j) / parts};
  };
  std::vector<std::array<Barycentric3, 3>> triangles;
  for (int i = 0; i < parts; ++i)
    for (int j = 0; i + j < parts; ++j) {
      triangles.push_back({corner(i, j), corner(i + 1, j), corner(i, j + 1)});
      if (i + j + 1 < parts) triangles.push_back({corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  return triangles;
}

}  // namespace

Eigen::Matrix<double, 10, 1> element_shape(const Barycentric4& L) {
  Eigen::Matrix<double, 10, 1> N;
  for (int k = 0; k < 4; ++k)
    N(k) = L[static_cast<std::size_t>(k)] * (2.0 * L[static_cast<std::size_t>(k)] - 1.0);
  for (int e = 0; e < 6; ++e) {
    const auto& edge = kElementEdges[static_cast<std::size_t>(e)];
    N(4 + e) = 4.0 * L[static_cast<std::size_t>(edge[0])] * L[static_cast<std::size_t>(edge[1])];
  }
  return N;
}

ElementGradients element_shape_derivatives(const Barycentric4& L) {
  ElementGradients dN;
  for (int d = 0; d < 3; ++d) {
    for (int k = 0; k < 4; ++k) dN(k, d) = (4.0 * L[static_cast<std::size_t>(k)] - 1.0) * slope<3>(k, d);
    for (int e = 0; e < 6; ++e) {
      const auto [a, b] = kElementEdges[static_cast<std::size_t>(e)];
      dN(4 + e, d) = 4.0 * (L[static_cast<std::size_t>(a)] * slope<3>(b, d) +
                            L[static_cast<std::size_t>(b)] * slope<3>(a, d));
    }
  }
  return dN;
}

Eigen::Matrix<double, 6, 1> facet_shape(const Barycentric3& L) {
  Eigen::Matrix<double, 6, 1> N;
  for (std::size_t k = 0; k < 3; ++k) N(static_cast<int>(k)) = L[k] * (2.0 * L[k] - 1.0);
  for (std::size_t e = 0; e < 3; ++e)
    N(3 + static_cast<int>(e)) =
        4.0 * L[static_cast<std::size_t>(kFacetEdges[e][0])] * L[static_cast<std::size_t>(kFacetEdges[e][1])];
  return N;
}

Eigen::Matrix<double, 6, 2> facet_shape_derivatives(const Barycentric3& L) {
  Eigen::Matrix<double, 6, 2> dN;
  for (int d = 0; d < 2; ++d) {
    for (int k = 0; k < 3; ++k) dN(k, d) = (4.0 * L[static_cast<std::size_t>(k)] - 1.0) * slope<2>(k, d);
    for (int e = 0; e < 3; ++e) {
      const auto [a, b] = kFacetEdges[static_cast<std::size_t>(e)];
      dN(3 + e, d) = 4.0 * (L[static_cast<std::size_t>(a)] * slope<2>(b, d) +
                            L[static_cast<std::size_t>(b)] * slope<2>(a, d));
    }
  }
  return dN;
}

const std::array<ElementPoint, 4>& element_rule() {
  static const std::array<ElementPoint, 4> rule = [] {
    const double far = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0, near = (5.0 - std::sqrt(5.0)) / 20.0;
    std::array<ElementPoint, 4> points{};
    for (std::size_t k = 0; k < 4; ++k) {
      points[k] = {{near, near, near, near}, 0.25};
      points[k].L[k] = far;
    }
    return points;
  }();
  return rule;
}

const std::array<FacetPoint, 7>& facet_rule() {
  static const std::array<FacetPoint, 7> rule = [] {
    const double root = std::sqrt(15.0), third = 1.0 / 3.0;
    std::array<FacetPoint, 7> points{};
    points[0] = {{third, third, third}, 9.0 / 40.0};
    for (std::size_t k = 0; k < 3; ++k) {
      const double a = (6.0 - root) / 21.0, b = (6.0 + root) / 21.0;
      points[1 + k] = {{a, a, a}, (155.0 - root) / 1200.0};
      points[1 + k].L[k] = 1.0 - 2.0 * a;
      points[4 + k] = {{b, b, b}, (155.0 + root) / 1200.0};
      points[4 + k].L[k] = 1.0 - 2.0 * b;
    }
    return points;
  }();
  return rule;
}

std::vector<FacetPoint> divided_facet_rule(int parts) {
  std::vector<FacetPoint> points;
  for (const auto& triangle : parts_of_facet(parts))
    for (const auto& point : facet_rule()) {
      Barycentric3 L{};
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c) L[c] += point.L[k] * triangle[k][c];
      points.push_back({L, point.weight / (parts * parts)});
    }
  return points;
}

Eigen::Matrix<double, 10, 3> places_of(const TetMesh& mesh, const QuadraticElement& element) {
  Eigen::Matrix<double, 10, 3> X;
  for (int k = 0; k < 10; ++k)
    X.row(k) = mesh.nodes[static_cast<std::size_t>(element[static_cast<std::size_t>(k)])].transpose();
  return X;
}

Eigen::Matrix<double, 6, 3> places_of(const TetMesh& mesh, const QuadraticFacet& facet) {
  Eigen::Matrix<double, 6, 3> X;
  for (int k = 0; k < 6; ++k)
    X.row(k) = mesh.nodes[static_cast<std::size_t>(facet[static_cast<std::size_t>(k)])].transpose();
  return X;
}

}  // namespace palpate::physics::deformable
