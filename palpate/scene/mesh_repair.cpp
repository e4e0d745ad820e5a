#include "palpate/scene/mesh_repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "palpate/core/text.h"

namespace palpate::scene {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

using Corners = std::array<std::uint32_t, 3>;

std::size_t weld(TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const auto &x = mesh.vertices[a], &y = mesh.vertices[b];
    for (Eigen::Index i = 0; i < 3; ++i)
      if (x[i] != y[i]) return x[i] < y[i];
    return false;
  };
  std::stable_sort(order.begin(), order.end(), less);
  std::vector<std::uint32_t> same_as(order.size());  // the first of its equals
  std::size_t welded = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool again = i > 0 && !less(order[i - 1], order[i]);
    same_as[order[i]] = again ? same_as[order[i - 1]] : order[i];
    welded += again;
  }
  for (auto& t : mesh.triangles)
    for (auto& corner : t) corner = same_as[corner];
  return welded;
}

bool has_area(const TriangleMesh& mesh, const Corners& t) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return false;
  // Scaled to its longest edge: the square of a very small area would be no number any more.
  const Vector3 a = mesh.vertices[t[1]] - mesh.vertices[t[0]], b = mesh.vertices[t[2]] - mesh.vertices[t[0]];
  const double longest = std::max({a.norm(), b.norm(), (b - a).norm()});
  constexpr double kRounding = 1e-14;  // width by length; what three places on a line leave over
  return (a / longest).cross(b / longest).norm() > kRounding;
}

// Keeps of the triangles those for which keep(i) holds.
template <typename Keep>
std::size_t drop(TriangleMesh& mesh, Keep&& keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (keep(i)) mesh.triangles[kept++] = mesh.triangles[i];
  const std::size_t dropped = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  return dropped;
}

std::size_t drop_repeated(TriangleMesh& mesh) {
  std::vector<std::pair<Corners, std::uint32_t>> sorted;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    auto t = mesh.triangles[i];
    std::sort(t.begin(), t.end());
    sorted.emplace_back(t, i);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<bool> again(sorted.size(), false);
  for (std::size_t i = 1; i < sorted.size(); ++i)
    again[sorted[i].second] = sorted[i].first == sorted[i - 1].first;
  return drop(mesh, [&](std::size_t i) { return !again[i]; });
}

struct Side {  // of a triangle, as an edge whose ends are in order
  std::uint32_t low, high, triangle, index;
  bool forward;  // the triangle goes from low to high
};

// Who lies across each side of each triangle, and whether it faces the other way.
struct Neighbours {
  std::vector<Corners> across;
  std::vector<std::array<bool, 3>> against;
};

Neighbours find_neighbours(const TriangleMesh& mesh, MeshRepair& report) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return std::tie(x.low, x.high, x.triangle) < std::tie(y.low, y.high, y.triangle);
  });
  Neighbours found;
  found.across.assign(mesh.triangles.size(), {kNone, kNone, kNone});
  found.against.assign(mesh.triangles.size(), {});
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    while (last < sides.size() && sides[last].low == sides[first].low &&
           sides[last].high == sides[first].high)
      ++last;
    if (last - first == 1) ++report.open_edges;
    if (last - first > 2) ++report.branching_edges;
    if (last - first != 2) continue;
    const Side &x = sides[first], &y = sides[first + 1];
    found.across[x.triangle][x.index] = y.triangle;
    found.across[y.triangle][y.index] = x.triangle;
    found.against[x.triangle][x.index] = found.against[y.triangle][y.index] = x.forward == y.forward;
  }
  return found;
}

void orient(TriangleMesh& mesh, MeshRepair& report) {
  const Neighbours neighbours = find_neighbours(mesh, report);
  std::vector<signed char> turn(mesh.triangles.size(), -1);  // -1: not reached yet
  std::vector<std::uint32_t> part;
  for (std::uint32_t start = 0; start < mesh.triangles.size(); ++start) {
    if (turn[start] >= 0) continue;
    part.assign(1, start);
    turn[start] = 0;
    bool closed = true;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const auto t = part[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const auto other = neighbours.across[t][k];
        if (other == kNone) {
          closed = false;
          continue;
        }
        const auto wanted = static_cast<signed char>(neighbours.against[t][k] ? 1 - turn[t] : turn[t]);
        if (turn[other] < 0) {
          turn[other] = wanted;
          part.push_back(other);
        } else if (turn[other] != wanted) {
          report.one_sided = true;
        }
      }
    }
    ++report.parts;
    std::size_t turned = 0;
    double volume = 0.0;  // from the part's own first corner, so that no distance swamps it
    const Vector3 origin = mesh.vertices[mesh.triangles[start][0]];
    for (const auto t : part) {
      turned += turn[t] == 1;
      const auto& c = mesh.triangles[t];
      const double six = (mesh.vertices[c[0]] - origin)
                             .dot((mesh.vertices[c[1]] - origin).cross(mesh.vertices[c[2]] - origin));
      volume += turn[t] == 1 ? -six : six;
    }
    const bool all_over = closed ? volume < 0.0 : 2 * turned > part.size();
    for (const auto t : part) {
      if ((turn[t] == 1) == all_over) continue;
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      ++report.turned_triangles;
    }
  }
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> place(mesh.vertices.size(), kNone);
  std::vector<Vector3> used;
  for (auto& t : mesh.triangles) {
    for (auto& corner : t) {
      if (place[corner] == kNone) {
        place[corner] = static_cast<std::uint32_t>(used.size());
        used.push_back(mesh.vertices[corner]);
      }
      corner = place[corner];
    }
  }
  mesh.vertices = std::move(used);
}

}  // namespace

MeshRepair repair(TriangleMesh& mesh) {
  MeshRepair report;
  report.welded_vertices = weld(mesh);
  report.dropped_triangles = drop(mesh, [&](std::size_t i) { return has_area(mesh, mesh.triangles[i]); });
  report.repeated_triangles = drop_repeated(mesh);
  orient(mesh, report);
  drop_unused_vertices(mesh);
  mesh.version.raise();
  return report;
}

std::string MeshRepair::text() const {
  std::string line = counted(parts, "part") + (closed() ? ", closed" : "");
  const auto add = [&](std::size_t number, const char* noun, const char* what) {
    if (number > 0) line += ", " + counted(number, noun) + ' ' + what;
  };
  add(open_edges, "edge", "open");
  add(branching_edges, "edge", "of three triangles or more");
  if (one_sided) line += ", one-sided";
  if (welded_vertices > 0) line += fmt::format(", {} equal vertices merged", welded_vertices);
  add(dropped_triangles, "triangle", "without area dropped");
  add(repeated_triangles, "triangle", "there twice dropped");
  add(turned_triangles, "triangle", "turned round");
  return line;
}

}  // namespace palpate::scene
