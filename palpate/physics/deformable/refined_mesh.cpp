#include "palpate/physics/deformable/refined_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace palpate::physics::deformable {
namespace {

constexpr std::size_t kMostElements = 200'000;

using Ends = std::pair<int, int>;  // of an edge, the lower number first

class Bisection {
 public:
  Bisection(const TetMesh& mesh, const std::function<Vector3(const Vector3&)>& onto_surface)
      : onto_surface_(onto_surface) {
    int corners = 0;
    for (const auto& element : mesh.elements) {
      corners = std::max(corners, 1 + *std::max_element(element.begin(), element.begin() + 4));
      add({element[0], element[1], element[2], element[3]});
    }
    corners_.assign(mesh.nodes.begin(), mesh.nodes.begin() + corners);
    for (const auto& facet : mesh.facets) surface_.insert(face_of(facet[0], facet[1], facet[2]));
  }

  Expected<void> refine(const std::function<double(const Vector3&)>& longest) {
    // Elements that are added come last and are looked at, too.
    for (std::size_t t = 0; t < all_.size(); ++t) {
      if (all_.size() > 4 * kMostElements || alive_ > kMostElements)
        return refused("mesh: it would take more than {} elements to be so fine", kMostElements);
      while (is_there_[t] && length2(longest_of(t)) > square(longest(middle_of(t)))) halve_towards(t);
    }
    return {};
  }

  Expected<TetMesh> result() && {
    std::vector<Tetrahedron> kept;
    for (std::size_t t = 0; t < all_.size(); ++t)
      if (is_there_[t]) kept.push_back(all_[t]);
    return quadratic_mesh(std::move(corners_), kept);
  }

 private:
  static double square(double x) { return x * x; }
  static Ends ends(int a, int b) { return {std::min(a, b), std::max(a, b)}; }
  static std::uint64_t key(const Ends& e) {
    return (static_cast<std::uint64_t>(e.first) << 32) | static_cast<std::uint64_t>(e.second);
  }
  static std::array<int, 3> face_of(int a, int b, int c) {
    std::array<int, 3> face{a, b, c};
    std::sort(face.begin(), face.end());
    return face;
  }
  const Vector3& corner(int c) const { return corners_[static_cast<std::size_t>(c)]; }
  double length2(const Ends& e) const { return (corner(e.first) - corner(e.second)).squaredNorm(); }
  bool longer(const Ends& a, const Ends& b) const {
    return std::make_tuple(length2(a), a) > std::make_tuple(length2(b), b);
  }
  Vector3 middle_of(std::size_t t) const {
    return 0.25 * (corner(all_[t][0]) + corner(all_[t][1]) + corner(all_[t][2]) + corner(all_[t][3]));
  }
  Ends longest_of(std::size_t t) const {
    Ends best = ends(all_[t][0], all_[t][1]);
    for (const auto& [i, j] : kElementEdges) {
      const Ends e = ends(all_[t][static_cast<std::size_t>(i)], all_[t][static_cast<std::size_t>(j)]);
      if (longer(e, best)) best = e;
    }
    return best;
  }

  void add(const Tetrahedron& tetrahedron) {
    for (const auto& [i, j] : kElementEdges)
      around_[key(ends(tetrahedron[static_cast<std::size_t>(i)], tetrahedron[static_cast<std::size_t>(j)]))]
          .push_back(all_.size());
    all_.push_back(tetrahedron);
    is_there_.push_back(true);
    ++alive_;
  }
  void remove(std::size_t t) {
    is_there_[t] = false;
    --alive_;
    for (const auto& [i, j] : kElementEdges) {
      auto& list =
          around_[key(ends(all_[t][static_cast<std::size_t>(i)], all_[t][static_cast<std::size_t>(j)]))];
      list.erase(std::find(list.begin(), list.end(), t));
    }
  }

  // One edge, the longest of the longest ones of neighbours that t's longest leads to.
  void halve_towards(std::size_t t) {
    Ends edge = longest_of(t);
    for (bool found = true; found;) {
      found = false;
      for (const std::size_t other : around_[key(edge)])
        if (const Ends e = longest_of(other); longer(e, edge)) {
          edge = e;
          found = true;
          break;
        }
    }
    halve(edge);
  }

  void halve(const Ends& edge) {
    const std::vector<std::size_t> parents = around_[key(edge)];
    const int middle = static_cast<int>(corners_.size());
    corners_.push_back(0.5 * (corner(edge.first) + corner(edge.second)));
    std::vector<Tetrahedron> children;
    bool on_surface = false;
    for (const std::size_t t : parents) {
      for (const int keep : {edge.first, edge.second}) {
        Tetrahedron child = all_[t];
        std::replace(child.begin(), child.end(), keep == edge.first ? edge.second : edge.first, middle);
        children.push_back(child);
      }
      for (const int c : all_[t]) {
        if (c == edge.first || c == edge.second) continue;
        if (surface_.erase(face_of(edge.first, edge.second, c)) == 0) continue;
        on_surface = true;
        surface_.insert(face_of(edge.first, middle, c));
        surface_.insert(face_of(middle, edge.second, c));
      }
    }
    for (const std::size_t t : parents) remove(t);
    if (on_surface && onto_surface_) move(middle, children);
    for (const Tetrahedron& child : children) add(child);
  }

  void move(int middle, const std::vector<Tetrahedron>& around) {
    constexpr double kKept = 0.3;  // of an element's volume, at least
    Vector3& place = corners_[static_cast<std::size_t>(middle)];
    const Vector3 straight = place, moved = onto_surface_(place);
    if (!moved.allFinite()) return;
    std::vector<double> before;
    for (const auto& t : around) before.push_back(six_volumes(t));
    place = moved;
    for (std::size_t k = 0; k < around.size(); ++k)
      if (!(six_volumes(around[k]) > kKept * before[k])) place = straight;
  }
  double six_volumes(const Tetrahedron& t) const {
    const Vector3& o = corner(t[0]);
    return (corner(t[1]) - o).cross(corner(t[2]) - o).dot(corner(t[3]) - o);
  }

  const std::function<Vector3(const Vector3&)>& onto_surface_;
  std::vector<Vector3> corners_;
  std::vector<Tetrahedron> all_;
  std::vector<bool> is_there_;
  std::size_t alive_ = 0;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> around_;  // elements at an edge
  std::set<std::array<int, 3>> surface_;
};

}  // namespace

Expected<TetMesh> refined_mesh(const TetMesh& mesh, const std::function<double(const Vector3&)>& longest,
                               const std::function<Vector3(const Vector3&)>& onto_surface) {
  Bisection bisection(mesh, onto_surface);
  if (auto done = bisection.refine(longest); !done) return tl::unexpected(done.error());
  return std::move(bisection).result();
}

}  // namespace palpate::physics::deformable
