// Shape functions of the ten-node tetrahedron and the six-node triangle, and where they are integrated.
//
// Barycentric coordinates L of the corners; no units. Node order as in tet_mesh.h. Pure functions without
// allocation. Source: Zienkiewicz, Taylor, volume 1; the four-point rule of degree 2 by Hammer, Stroud (1956),
// the seven-point rule of degree 5 by Radon (1948).
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "palpate/physics/deformable/tet_mesh.h"

namespace palpate::physics::deformable {

using Barycentric4 = std::array<double, 4>;
using Barycentric3 = std::array<double, 3>;
using ElementGradients = Eigen::Matrix<double, 10, 3>;  // a row per node

Eigen::Matrix<double, 10, 1> element_shape(const Barycentric4& L);
// Derivatives by L_1, L_2, L_3 with L_0 = 1 - L_1 - L_2 - L_3.
ElementGradients element_shape_derivatives(const Barycentric4& L);
Eigen::Matrix<double, 6, 1> facet_shape(const Barycentric3& L);
// Derivatives by L_1, L_2 with L_0 = 1 - L_1 - L_2.
Eigen::Matrix<double, 6, 2> facet_shape_derivatives(const Barycentric3& L);

// Weights sum to 1.
struct ElementPoint {
  Barycentric4 L;
  double weight;
};
struct FacetPoint {
  Barycentric3 L;
  double weight;
};
const std::array<ElementPoint, 4>& element_rule();
const std::array<FacetPoint, 7>& facet_rule();
// The seven points in each of parts^2 equal triangles.
std::vector<FacetPoint> divided_facet_rule(int parts);

// Rows are the places of an element's or a facet's nodes.
Eigen::Matrix<double, 10, 3> places_of(const TetMesh& mesh, const QuadraticElement& element);
Eigen::Matrix<double, 6, 3> places_of(const TetMesh& mesh, const QuadraticFacet& facet);

}  // namespace palpate::physics::deformable
