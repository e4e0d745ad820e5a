#include "palpate/physics/deformable/stuffed_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace palpate::physics::deformable {
namespace {

// A cut so near to an end of its edge, in parts of the edge, moves the end onto the surface.
constexpr double kNearOnLong = 0.24999, kNearOnShort = 0.41189;
constexpr double kMostLatticePoints = 4e6;
constexpr int kBorder = 2;              // cells around the body
constexpr int kCutSteps = 20;           // of the search for the surface on an edge
constexpr double kCutTolerance = 1e-6;  // in spacings
constexpr double kCrumbs =
    0.02;  // of the elements: so many may hang on the body by less than a face and are left out

using Corner = std::uint32_t;

// The points of two cubic lattices, the second in the middles of the first one's cells.
class Stuffing {
 public:
  Stuffing(const SignedDistance& distance, const StuffedMeshSettings& settings)
      : distance_(distance), spacing_(settings.spacing) {
    const Vector3 extent = settings.high - settings.low;
    for (Eigen::Index i = 0; i < 3; ++i)
      count_[static_cast<std::size_t>(i)] =
          static_cast<int>(std::ceil(extent[i] / spacing_)) + 1 + 2 * kBorder;
    for (Eigen::Index i = 0; i < 3; ++i)
      origin_[i] = 0.5 * (settings.low[i] + settings.high[i]) -
                   0.5 * spacing_ * (count_[static_cast<std::size_t>(i)] - 1);
  }

  void fill() {
    lay_points();
    find_tetrahedra();
    cut_edges();
    move_near_points();
    for (const auto& tetrahedron : lattice_) stuff(tetrahedron);
  }

  const std::vector<Tetrahedron>& stuffed() const { return stuffed_; }

  // The corners of these tetrahedra, in the order of their first use, and the tetrahedra by their numbers there.
  std::pair<std::vector<Vector3>, std::vector<Tetrahedron>> numbered(
      std::vector<Tetrahedron> tetrahedra) const {
    std::vector<int> numbers(points_.size(), -1);
    std::vector<Vector3> corners;
    for (auto& tetrahedron : tetrahedra)
      for (int& c : tetrahedron) {
        int& number = numbers[static_cast<std::size_t>(c)];
        if (number < 0) {
          number = static_cast<int>(corners.size());
          corners.push_back(points_[static_cast<std::size_t>(c)]);
        }
        c = number;
      }
    return {std::move(corners), std::move(tetrahedra)};
  }

 private:
  Corner corner(int x, int y, int z) const {
    return static_cast<Corner>((z * count_[1] + y) * count_[0] + x);
  }
  Corner centre(int x, int y, int z) const { return corner(x, y, z) + cubic_; }
  bool is_centre(Corner c) const { return c >= cubic_; }  // of the lattice's points
  bool is_long(Corner a, Corner b) const { return is_centre(a) == is_centre(b); }
  int side(Corner c) const { return sides_[c]; }  // 1 inside, 0 on the surface, -1 outside

  void lay_points() {
    cubic_ = static_cast<Corner>(count_[0] * count_[1] * count_[2]);
    points_.resize(2 * cubic_);
    for (int z = 0; z < count_[2]; ++z)
      for (int y = 0; y < count_[1]; ++y)
        for (int x = 0; x < count_[0]; ++x) {
          const Vector3 at = origin_ + spacing_ * Vector3(x, y, z);
          points_[corner(x, y, z)] = at;
          points_[centre(x, y, z)] = at + Vector3::Constant(0.5 * spacing_);
        }
    for (const Vector3& p : points_) {
      distances_.push_back(distance_(p));
      sides_.push_back(distances_.back() < 0.0 ? 1 : -1);
    }
  }

  // Around each edge between two centres are four of them; both ends of a short edge are in different lattices.
  void find_tetrahedra() {
    for (int z = 1; z + 1 < count_[2]; ++z)
      for (int y = 1; y + 1 < count_[1]; ++y)
        for (int x = 1; x + 1 < count_[0]; ++x)
          for (int axis = 0; axis < 3; ++axis) {
            std::array<int, 3> cell{x, y, z}, next = cell;
            ++next[static_cast<std::size_t>(axis)];
            around(cell, next, static_cast<std::size_t>(axis));
          }
  }
  void around(const std::array<int, 3>& cell, const std::array<int, 3>& next, std::size_t axis) {
    const Corner a = centre(cell[0], cell[1], cell[2]), b = centre(next[0], next[1], next[2]);
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    constexpr std::array<std::array<int, 2>, 4> kSquare{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    std::array<Corner, 4> square{};
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<int, 3> at = next;
      at[u] += kSquare[k][0];
      at[v] += kSquare[k][1];
      square[k] = corner(at[0], at[1], at[2]);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const std::array<Corner, 4> t{a, b, square[k], square[(k + 1) % 4]};
      if (std::any_of(t.begin(), t.end(), [&](Corner c) { return sides_[c] > 0; })) lattice_.push_back(t);
    }
  }

  static std::uint64_t edge_of(Corner a, Corner b) {
    if (a > b) std::swap(a, b);
    return (static_cast<std::uint64_t>(a) << 32) | b;
  }

  // Of every edge whose ends lie on different sides.
  void cut_edges() {
    for (const auto& t : lattice_)
      for (const auto& [i, j] : kElementEdges) {
        const Corner a = t[static_cast<std::size_t>(i)], b = t[static_cast<std::size_t>(j)];
        if (side(a) * side(b) >= 0 || !cuts_.try_emplace(edge_of(a, b), 0).second) continue;
        cut(a, b);
      }
  }
  // By false position: the distance is nearly linear there.
  double place_of_cut(Corner a, Corner b) const {
    double low = 0.0, high = 1.0, at_low = distances_[a], at_high = distances_[b], part = 0.5;
    for (int step = 0; step < kCutSteps; ++step) {
      part = low + (high - low) * std::clamp(at_low / (at_low - at_high), 0.05, 0.95);
      const double here = distance_(points_[a] + part * (points_[b] - points_[a]));
      if (std::abs(here) < kCutTolerance * spacing_) break;
      const bool like_low = (here < 0.0) == (at_low < 0.0);
      (like_low ? low : high) = part;
      (like_low ? at_low : at_high) = here;
    }
    return part;
  }
  void cut(Corner a, Corner b) {
    if (a > b) std::swap(a, b);
    const double part = place_of_cut(a, b);
    const auto number = static_cast<Corner>(points_.size());
    points_.push_back(points_[a] + part * (points_[b] - points_[a]));
    sides_.push_back(0);
    cuts_[edge_of(a, b)] = number;
    const double near = is_long(a, b) ? kNearOnLong : kNearOnShort;
    if (part < near) near_[a].push_back({part / near, number, b});
    if (1.0 - part < near) near_[b].push_back({(1.0 - part) / near, number, a});
  }

  // In the points' order, so that the same body always gives the same mesh. A point goes to the nearest cut of an edge
  // whose other end has stayed; cuts of its own edges then are not used, for it lies on the surface.
  void move_near_points() {
    for (auto& [point, cuts] : near_) {
      std::sort(cuts.begin(), cuts.end(), [](const NearCut& x, const NearCut& y) {
        return std::tie(x.share, x.number) < std::tie(y.share, y.number);
      });
      for (const NearCut& near : cuts) {
        if (side(near.other) == 0) continue;
        points_[point] = points_[near.number];
        sides_[point] = 0;
        break;
      }
    }
  }

  void add(Corner a, Corner b, Corner c, Corner d) {
    const Vector3& o = points_[a];
    if ((points_[b] - o).cross(points_[c] - o).dot(points_[d] - o) < 0.0) std::swap(c, d);
    stuffed_.push_back({static_cast<int>(a), static_cast<int>(b), static_cast<int>(c), static_cast<int>(d)});
  }
  Corner cut_of(Corner a, Corner b) const { return cuts_.at(edge_of(a, b)); }

  // The quadrilateral of two inner corners and the cuts on their edges to the outer one, which two tetrahedra share:
  // whether its diagonal begins at `a`.
  bool from_first(Corner a, Corner b, Corner out) const {
    if (is_long(a, b)) {
      const double of_a = (points_[a] - points_[cut_of(b, out)]).squaredNorm();
      const double of_b = (points_[b] - points_[cut_of(a, out)]).squaredNorm();
      return of_a != of_b ? of_a < of_b : a < b;
    }
    return !is_long(a, out);
  }

  // A wedge with the triangles p and q and the edges p[i] q[i]; `up[i]`: the diagonal of the side between i and i + 1
  // begins at p[i]. Not all three the same way round.
  void add_wedge(const std::array<Corner, 3>& p, const std::array<Corner, 3>& q,
                 const std::array<bool, 3>& up) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      if (!up[i] || up[k]) continue;  // both diagonals at edge i begin at p[i]
      add(p[i], q[0], q[1], q[2]);
      if (up[j]) {
        add(p[i], p[j], p[k], q[k]);
        add(p[i], p[j], q[j], q[k]);
      } else {
        add(p[i], p[j], p[k], q[j]);
        add(p[i], p[k], q[j], q[k]);
      }
      return;
    }
  }

  void stuff(const std::array<Corner, 4>& t) {
    std::vector<Corner> in, on, out;
    for (const Corner c : t) (side(c) > 0 ? in : side(c) == 0 ? on : out).push_back(c);
    if (in.empty()) return;
    if (out.empty()) return add(t[0], t[1], t[2], t[3]);
    if (in.size() == 1) {
      std::vector<Corner> base = on;
      for (const Corner c : out) base.push_back(cut_of(in[0], c));
      return add(in[0], base[0], base[1], base[2]);
    }
    if (in.size() == 3)
      return add_wedge({in[0], in[1], in[2]},
                       {cut_of(in[0], out[0]), cut_of(in[1], out[0]), cut_of(in[2], out[0])},
                       {from_first(in[0], in[1], out[0]), from_first(in[1], in[2], out[0]),
                        from_first(in[2], in[0], out[0])});
    const Corner a = in[0], b = in[1];
    if (on.size() == 1) {
      const Corner ca = cut_of(a, out[0]), cb = cut_of(b, out[0]);
      if (from_first(a, b, out[0])) return add(on[0], a, b, cb), add(on[0], a, ca, cb);
      return add(on[0], a, b, ca), add(on[0], b, ca, cb);
    }
    // Edges from the inner pair: a b, and from the cuts at each outer corner.
    const std::array<Corner, 3> p{a, cut_of(a, out[0]), cut_of(a, out[1])};
    const std::array<Corner, 3> q{b, cut_of(b, out[0]), cut_of(b, out[1])};
    const bool first = from_first(a, b, out[0]), last = !from_first(a, b, out[1]);
    const bool shorter =
        (points_[p[1]] - points_[q[2]]).squaredNorm() < (points_[p[2]] - points_[q[1]]).squaredNorm();
    add_wedge(p, q, {first, first == last ? !first : shorter, last});
  }

  const SignedDistance& distance_;
  double spacing_;
  Vector3 origin_{0.0, 0.0, 0.0};
  std::array<int, 3> count_{};
  Corner cubic_ = 0;
  std::vector<Vector3> points_;
  std::vector<double> distances_;  // of the lattice's points where they were
  std::vector<int> sides_;
  std::vector<std::array<Corner, 4>> lattice_;
  std::vector<Tetrahedron> stuffed_;
  std::unordered_map<std::uint64_t, Corner> cuts_;
  struct NearCut {
    double share;  // of the distance that is near
    Corner number, other;
  };
  std::map<Corner, std::vector<NearCut>> near_;
};

// The part of each tetrahedron: they hang together by corners they share in the element matrices, but only faces hold.
std::vector<std::size_t> parts_of(const std::vector<Tetrahedron>& tetrahedra) {
  std::vector<std::size_t> part(tetrahedra.size());
  std::iota(part.begin(), part.end(), std::size_t{0});
  const auto root = [&](std::size_t t) {
    while (part[t] != t) t = part[t] = part[part[t]];
    return t;
  };
  std::map<std::array<int, 3>, std::size_t> faces;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      std::array<int, 3> face{};
      for (std::size_t k = 0, n = 0; k < 4; ++k)
        if (k != left_out) face[n++] = tetrahedra[t][k];
      std::sort(face.begin(), face.end());
      const auto [other, is_new] = faces.try_emplace(face, t);
      if (!is_new) part[root(t)] = root(other->second);
    }
  for (std::size_t t = 0; t < part.size(); ++t) part[t] = root(t);
  return part;
}

// Crumbs, as a thin rim leaves them, are left out.
Expected<std::vector<Tetrahedron>> greatest_part(const std::vector<Tetrahedron>& tetrahedra) {
  const auto part = parts_of(tetrahedra);
  std::map<std::size_t, std::size_t> sizes;
  for (const std::size_t p : part) ++sizes[p];
  const auto greatest = std::max_element(sizes.begin(), sizes.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto others = static_cast<double>(tetrahedra.size() - greatest->second);
  if (others > kCrumbs * static_cast<double>(tetrahedra.size()))
    return refused("mesh: the body falls into {} parts; one is expected: take a smaller spacing",
                   sizes.size());
  std::vector<Tetrahedron> kept;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t)
    if (part[t] == greatest->first) kept.push_back(tetrahedra[t]);
  return kept;
}

Expected<void> check_stuffing(const StuffedMeshSettings& settings) {
  const Vector3 extent = settings.high - settings.low;
  if (!(settings.spacing > 0.0 && extent.allFinite() && extent.minCoeff() > 0.0))
    return wrong_use("mesh: a spacing of {} m and a box of {} m; both more than 0 are expected",
                     settings.spacing, extent.minCoeff());
  const double points = 2.0 * (extent / settings.spacing + Vector3::Constant(2.0 + 2.0 * kBorder)).prod();
  if (!(points <= kMostLatticePoints))
    return refused("mesh: a spacing of {:.3g} m takes {:.0f} lattice points, and {:.0f} are allowed",
                   settings.spacing, points, kMostLatticePoints);
  return {};
}

}  // namespace

Expected<TetMesh> stuffed_mesh(const SignedDistance& distance, const StuffedMeshSettings& settings) {
  if (auto good = check_stuffing(settings); !good) return tl::unexpected(good.error());
  Stuffing stuffing(distance, settings);
  stuffing.fill();
  auto kept = stuffing.stuffed().empty()
                  ? refused("mesh: no place of the body is as wide as {:.3g} m; take a smaller spacing",
                            settings.spacing)
                  : greatest_part(stuffing.stuffed());
  if (!kept) return tl::unexpected(kept.error());
  auto [corners, tetrahedra] = stuffing.numbered(*kept);
  return quadratic_mesh(std::move(corners), tetrahedra);
}

}  // namespace palpate::physics::deformable
