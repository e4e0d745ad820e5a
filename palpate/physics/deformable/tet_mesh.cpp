#include "palpate/physics/deformable/tet_mesh.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "palpate/physics/deformable/quadratic_shape.h"

namespace palpate::physics::deformable {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::uint64_t edge_key(int a, int b) {
  if (a > b) std::swap(a, b);
  return (static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint64_t>(b);
}

Expected<void> check_tetrahedra(const std::vector<Vector3>& corners,
                                const std::vector<Tetrahedron>& tetrahedra) {
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    for (const int corner : tetrahedra[t])
      if (corner < 0 || at(corner) >= corners.size())
        return refused("mesh: tetrahedron {} has corner {}, and there are {}", t, corner, corners.size());
    const auto& [a, b, c, d] = tetrahedra[t];
    const Vector3& origin = corners[at(a)];
    const double six_volumes =
        (corners[at(b)] - origin).cross(corners[at(c)] - origin).dot(corners[at(d)] - origin);
    if (!(six_volumes > 0.0))
      return refused("mesh: tetrahedron {} has the volume {:.3g} m3; a positive one is expected", t,
                     six_volumes / 6.0);
  }
  return {};
}

void add_middles(const std::vector<Tetrahedron>& tetrahedra, TetMesh& mesh) {
  std::unordered_map<std::uint64_t, int> middles;
  middles.reserve(2 * tetrahedra.size());
  for (const auto& tetrahedron : tetrahedra) {
    QuadraticElement element{};
    std::copy(tetrahedron.begin(), tetrahedron.end(), element.begin());
    for (std::size_t e = 0; e < kElementEdges.size(); ++e) {
      const int a = tetrahedron[at(kElementEdges[e][0])], b = tetrahedron[at(kElementEdges[e][1])];
      const auto [found, is_new] = middles.try_emplace(edge_key(a, b), static_cast<int>(mesh.nodes.size()));
      if (is_new) {
        const Vector3 middle = 0.5 * (mesh.nodes[at(a)] + mesh.nodes[at(b)]);
        mesh.nodes.push_back(middle);
      }
      element[4 + e] = found->second;
    }
    mesh.elements.push_back(element);
  }
}

struct FacetOfElement {
  std::array<int, 3> key;  // corners, rising
  int element, side;
  bool operator<(const FacetOfElement& other) const {
    return std::tie(key, element) < std::tie(other.key, other.element);
  }
};

Expected<void> find_surface(TetMesh& mesh) {
  std::vector<FacetOfElement> all;
  all.reserve(4 * mesh.elements.size());
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    for (int side = 0; side < 4; ++side) {
      const auto& local = kElementFacets[at(side)];
      std::array<int, 3> key{mesh.elements[e][at(local[0])], mesh.elements[e][at(local[1])],
                             mesh.elements[e][at(local[2])]};
      std::sort(key.begin(), key.end());
      all.push_back({key, static_cast<int>(e), side});
    }
  std::sort(all.begin(), all.end());
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].key == all[i].key) ++end;
    if (end - i > 2)
      return refused("mesh: {} tetrahedra share one triangle; at most two are expected", end - i);
    if (end - i == 1) {
      QuadraticFacet facet{};
      for (std::size_t k = 0; k < 6; ++k)
        facet[k] = mesh.elements[at(all[i].element)][at(kElementFacets[at(all[i].side)][k])];
      mesh.facets.push_back(facet);
      mesh.facet_elements.push_back(all[i].element);
    }
    i = end;
  }
  return {};
}

Matrix3 jacobian(const Eigen::Matrix<double, 10, 3>& X, const Barycentric4& L) {
  return X.transpose() * element_shape_derivatives(L);
}

}  // namespace

Expected<TetMesh> quadratic_mesh(std::vector<Vector3> corners, const std::vector<Tetrahedron>& tetrahedra) {
  if (auto good = check_tetrahedra(corners, tetrahedra); !good) return tl::unexpected(good.error());
  TetMesh mesh;
  mesh.nodes = std::move(corners);
  add_middles(tetrahedra, mesh);
  if (auto found = find_surface(mesh); !found) return tl::unexpected(found.error());
  return mesh;
}

double volume(const TetMesh& mesh) {
  double sum = 0.0;
  for (const auto& element : mesh.elements) {
    const auto X = places_of(mesh, element);
    for (const auto& point : element_rule()) sum += point.weight * jacobian(X, point.L).determinant() / 6.0;
  }
  return sum;
}

double surface_area(const TetMesh& mesh) {
  double sum = 0.0;
  for (const auto& facet : mesh.facets) {
    const auto X = places_of(mesh, facet);
    for (const auto& point : facet_rule()) {
      const Eigen::Matrix<double, 3, 2> tangents = X.transpose() * facet_shape_derivatives(point.L);
      sum += 0.5 * point.weight * tangents.col(0).cross(tangents.col(1)).norm();
    }
  }
  return sum;
}

Expected<void> check(const TetMesh& mesh) {
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    if (!mesh.nodes[i].allFinite()) return refused("mesh: node {} is not finite", i);
  std::vector<Barycentric4> tried;
  for (const auto& point : element_rule()) tried.push_back(point.L);
  for (std::size_t k = 0; k < 4; ++k) {
    Barycentric4 corner{};
    corner[k] = 1.0;
    tried.push_back(corner);
  }
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    for (const int node : mesh.elements[e])
      if (node < 0 || at(node) >= mesh.nodes.size())
        return refused("mesh: element {} has node {}, and there are {}", e, node, mesh.nodes.size());
    const auto X = places_of(mesh, mesh.elements[e]);
    for (const auto& L : tried)
      if (!(jacobian(X, L).determinant() > 0.0)) return refused("mesh: element {} is turned inside out", e);
  }
  return {};
}

DihedralAngles dihedral_angles(const TetMesh& mesh) {
  DihedralAngles angles{std::numbers::pi, 0.0};
  for (const auto& element : mesh.elements) {
    std::array<Vector3, 4> normals;
    for (std::size_t side = 0; side < 4; ++side) {
      const auto& local = kElementFacets[side];
      const Vector3& a = mesh.nodes[at(element[at(local[0])])];
      normals[side] = (mesh.nodes[at(element[at(local[1])])] - a)
                          .cross(mesh.nodes[at(element[at(local[2])])] - a)
                          .normalized();
    }
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) {
        const double angle = std::numbers::pi - std::acos(std::clamp(normals[i].dot(normals[j]), -1.0, 1.0));
        angles.smallest = std::min(angles.smallest, angle);
        angles.largest = std::max(angles.largest, angle);
      }
  }
  return angles;
}

}  // namespace palpate::physics::deformable
