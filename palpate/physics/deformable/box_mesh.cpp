#include "palpate/physics/deformable/box_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace palpate::physics::deformable {
namespace {

using Hexahedron = std::array<int, 8>;  // corner number: x + 2 y + 4 z

// Six faces of a hexahedron, corners in turn, counter-clockwise seen from outside.
constexpr std::array<std::array<int, 4>, 6> kHexahedronFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

// The face's diagonal starts at its corner of lowest number, so that neighbours cut a face alike (Dompierre et
// al., How to subdivide pyramids, prisms and hexahedra into tetrahedra, 1999).
void split(const Hexahedron& cell, std::vector<Tetrahedron>& out) {
  const int first = *std::min_element(cell.begin(), cell.end());
  for (const auto& face : kHexahedronFaces) {
    std::array<int, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) corners[k] = cell[static_cast<std::size_t>(face[k])];
    if (std::find(corners.begin(), corners.end(), first) != corners.end()) continue;
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    // Seen from outside they turn counter-clockwise, from the inner corner clockwise.
    out.push_back({corners[0], corners[2], corners[1], first});
    out.push_back({corners[0], corners[3], corners[2], first});
  }
}

class BoxBuilder {
 public:
  explicit BoxBuilder(const BoxMeshSettings& settings) : s_(settings) {
    lowest_ = {s_.half_x ? 0 : -s_.cells, s_.half_y ? 0 : -s_.cells, -s_.cells_down};
    scale_ = Vector3(0.5 * s_.size.x() / s_.core, 0.5 * s_.size.y() / s_.core, s_.size.z() / s_.core_depth);
    ends_ = {graded(0.5 * s_.size.x() - s_.core, s_.core / s_.cells),
             graded(0.5 * s_.size.y() - s_.core, s_.core / s_.cells),
             graded(s_.size.z() - s_.core_depth, s_.core_depth / s_.cells_down)};
  }

  void build() {
    std::array<int, 3> c{};
    for (c[2] = lowest_[2]; c[2] < 0; ++c[2])
      for (c[1] = lowest_[1]; c[1] < s_.cells; ++c[1])
        for (c[0] = lowest_[0]; c[0] < s_.cells; ++c[0]) add_core_cell(c);
    for (int axis = 0; axis < 3; ++axis)
      for (const bool upper : {false, true}) add_shells(axis, upper);
  }

  std::vector<Vector3> corners;
  std::vector<Tetrahedron> tetrahedra;

 private:
  // Where the shells end along one axis, in parts of the way from core to side: the first one as thick as a core
  // cell, where it can be, each thicker by one factor than the one within.
  std::vector<double> graded(double reach, double cell) const {
    const double first = cell / reach;
    double low = 1.0, high = 10.0;
    const auto sum = [&](double g) {
      double total = 0.0, part = first;
      for (int i = 0; i < s_.shells; ++i, part *= g) total += part;
      return total;
    };
    for (int i = 0; i < 60; ++i) (sum(0.5 * (low + high)) < 1.0 ? low : high) = 0.5 * (low + high);
    std::vector<double> ends{0.0};
    double part = first;
    for (int i = 0; i < s_.shells; ++i, part *= low) ends.push_back(ends.back() + part);
    const double whole = ends.back();
    for (auto& end : ends) end /= whole;
    ends.back() = 1.0;
    return ends;
  }

  int node(const std::array<int, 3>& c, int shell) {
    const std::array<int, 4> key{c[0], c[1], c[2], shell};
    const auto [found, is_new] = numbers_.try_emplace(key, static_cast<int>(corners.size()));
    if (is_new) {
      const Vector3 inner(s_.core * c[0] / s_.cells, s_.core * c[1] / s_.cells,
                          s_.core_depth * c[2] / s_.cells_down);
      const auto k = static_cast<std::size_t>(shell);
      const Vector3 t(ends_[0][k], ends_[1][k], ends_[2][k]);
      corners.push_back(inner + t.cwiseProduct(scale_.cwiseProduct(inner) - inner));
    }
    return found->second;
  }

  void add_core_cell(const std::array<int, 3>& c) {
    Hexahedron cell{};
    for (int k = 0; k < 8; ++k)
      cell[static_cast<std::size_t>(k)] =
          node({c[0] + (k & 1), c[1] + ((k >> 1) & 1), c[2] + ((k >> 2) & 1)}, 0);
    split(cell, tetrahedra);
  }

  // Shells beyond one face of the core. The top is the block's own, and so are the planes of symmetry.
  void add_shells(int axis, bool upper) {
    if (axis == 2 && upper) return;
    if (!upper && ((axis == 0 && s_.half_x) || (axis == 1 && s_.half_y))) return;
    const std::array<int, 3> highest{s_.cells, s_.cells, 0};
    const auto a = static_cast<std::size_t>(axis), u = (a + 1) % 3, v = (a + 2) % 3;
    for (int shell = 0; shell < s_.shells; ++shell)
      for (int i = lowest_[u]; i < highest[u]; ++i)
        for (int j = lowest_[v]; j < highest[v]; ++j) {
          Hexahedron cell{};
          for (int k = 0; k < 8; ++k) {
            std::array<int, 3> c{};
            c[a] = upper ? highest[a] : lowest_[a];
            c[u] = i + (k & 1);
            c[v] = j + ((k >> 1) & 1);
            // Outwards is the third direction of the cell; beyond a lower face that is the other way round.
            const int outer = ((k >> 2) & 1) == (upper ? 1 : 0) ? 1 : 0;
            cell[static_cast<std::size_t>(k)] = node(c, shell + outer);
          }
          split(cell, tetrahedra);
        }
  }

  const BoxMeshSettings& s_;
  std::array<int, 3> lowest_{};
  Vector3 scale_;
  std::array<std::vector<double>, 3> ends_;
  std::map<std::array<int, 4>, int> numbers_;
};

double extent(const TetMesh& mesh) {
  double largest = 0.0;
  for (const auto& node : mesh.nodes) largest = std::max(largest, node.cwiseAbs().maxCoeff());
  return largest;
}

}  // namespace

Expected<TetMesh> box_mesh(const BoxMeshSettings& settings) {
  if (settings.cells < 1 || settings.cells_down < 1 || settings.shells < 1)
    return refused("block: {} x {} cells and {} shells; at least one of each is expected", settings.cells,
                   settings.cells_down, settings.shells);
  if (!(settings.core > 0.0 && settings.core < 0.5 * std::min(settings.size.x(), settings.size.y()) &&
        settings.core_depth > 0.0 && settings.core_depth < settings.size.z()))
    return refused(
        "block: a core of {:.3g} m half width and {:.3g} m depth does not fit in {:.3g} x {:.3g} x {:.3g} m",
        settings.core, settings.core_depth, settings.size.x(), settings.size.y(), settings.size.z());
  BoxBuilder builder(settings);
  builder.build();
  return quadratic_mesh(std::move(builder.corners), builder.tetrahedra);
}

std::vector<int> nodes_on_plane(const TetMesh& mesh, int axis, double value) {
  const double near = 1e-9 * extent(mesh);
  std::vector<int> nodes;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    if (std::abs(mesh.nodes[i][axis] - value) <= near) nodes.push_back(static_cast<int>(i));
  return nodes;
}

std::vector<int> facets_on_plane(const TetMesh& mesh, int axis, double value) {
  const double near = 1e-9 * extent(mesh);
  std::vector<int> facets;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const auto lies = [&](std::size_t k) {
      return std::abs(mesh.nodes[static_cast<std::size_t>(mesh.facets[f][k])][axis] - value) <= near;
    };
    if (lies(0) && lies(1) && lies(2)) facets.push_back(static_cast<int>(f));
  }
  return facets;
}

}  // namespace palpate::physics::deformable
