// A solid body of quadratic tetrahedra: ten nodes each, four corners and six middles of edges.
//
// Metres in the body's own frame. Values; functions without state; they allocate. Node order within an element:
// corners 0 to 3, then the middles of (0,1), (1,2), (2,0), (0,3), (1,3), (2,3); the corners 0, 1, 2 turn
// counter-clockwise seen from corner 3, so that the volume is positive. Order within a facet: corners
// counter-clockwise seen from outside, then the middles of (0,1), (1,2), (2,0).
// Source: Zienkiewicz, Taylor, The Finite Element Method, volume 1.
#pragma once

#include <array>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/so3.h"

namespace palpate::physics::deformable {

using Tetrahedron = std::array<int, 4>;
using QuadraticElement = std::array<int, 10>;
using QuadraticFacet = std::array<int, 6>;

struct TetMesh {
  std::vector<Vector3> nodes;
  std::vector<QuadraticElement> elements;
  std::vector<QuadraticFacet> facets;  // the surface
  std::vector<int> facet_elements;     // the element that a facet belongs to
};

// Pairs of corners whose middles are the nodes 4 to 9.
inline constexpr std::array<std::array<int, 2>, 6> kElementEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
// The local nodes of the four facets, each counter-clockwise seen from outside.
inline constexpr std::array<std::array<int, 6>, 4> kElementFacets{
    {{0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {2, 0, 3, 6, 7, 9}}};

// Middles of edges are added and the surface is found. Corners come first, in their own order. Refused: indices
// out of range, a tetrahedron without volume, three tetrahedra at one triangle.
Expected<TetMesh> quadratic_mesh(std::vector<Vector3> corners, const std::vector<Tetrahedron>& tetrahedra);

// Volume of the curved elements, m^3, by their quadrature points.
double volume(const TetMesh& mesh);
// Area of the curved surface, m^2.
double surface_area(const TetMesh& mesh);

// Elements that are turned inside out somewhere at their quadrature points or corners, a node that does not
// exist, a value that is not finite: refused in words.
Expected<void> check(const TetMesh& mesh);

// Smallest and largest angle between two facets of a tetrahedron, radians, over all elements' corners.
struct DihedralAngles {
  double smallest = 0.0, largest = 0.0;
};
DihedralAngles dihedral_angles(const TetMesh& mesh);

}  // namespace palpate::physics::deformable
