#include "palpate/physics/organ/surface_sites.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>

#include "palpate/core/random.h"

namespace palpate::physics::organ {
namespace {

constexpr double kClosest =
    0.84;                        // spacings: a full disc pattern has about the density of a square grid then
constexpr double kDrawn = 30.0;  // points for each square of the spacing
constexpr double kFacesTable = -0.3;  // cosine to the upward direction
constexpr double kHollow = 5.0;       // 1/m: of a cylinder of 20 cm, from inside
constexpr std::size_t kMostDrawn = 2'000'000;

// Points among which is looked for one that lies nearer than `closest`.
class Picks {
 public:
  explicit Picks(double closest) : closest_(closest) {}

  bool near(const Vector3& p) const {
    const auto at = cell(p);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const auto found = cells_.find({at[0] + x, at[1] + y, at[2] + z});
          if (found == cells_.end()) continue;
          for (const Vector3& other : found->second)
            if ((other - p).squaredNorm() < closest_ * closest_) return true;
        }
    return false;
  }
  void add(const Vector3& p) { cells_[cell(p)].push_back(p); }

 private:
  std::array<int, 3> cell(const Vector3& p) const {
    return {static_cast<int>(std::floor(p.x() / closest_)), static_cast<int>(std::floor(p.y() / closest_)),
            static_cast<int>(std::floor(p.z() / closest_))};
  }
  double closest_;
  std::map<std::array<int, 3>, std::vector<Vector3>> cells_;
};

// Points drawn evenly over what faces up, or aside.
class Draw {
 public:
  Draw(const scene::TriangleMesh& surface, const Vector3& up) : surface_(surface) {
    for (const auto& t : surface.triangles) {
      const Vector3& a = surface.vertices[t[0]];
      const Vector3 twice = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a);
      normals_.push_back(twice.normalized());
      area_ += normals_.back().dot(up) > kFacesTable ? 0.5 * twice.norm() : 0.0;
      up_to_.push_back(area_);
    }
  }

  double area() const { return area_; }

  deformable::SurfaceSite next(Random& random) const {
    const auto found = std::upper_bound(up_to_.begin(), up_to_.end() - 1, random.uniform(0.0, area_));
    const auto number = static_cast<std::size_t>(found - up_to_.begin());
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const auto& t = surface_.triangles[number];
    const Vector3& a = surface_.vertices[t[0]];
    return {a + u * (surface_.vertices[t[1]] - a) + v * (surface_.vertices[t[2]] - a), normals_[number]};
  }

 private:
  const scene::TriangleMesh& surface_;
  std::vector<double> up_to_;  // area of the triangles to here
  std::vector<Vector3> normals_;
  double area_ = 0.0;
};

// Whether the surface rises above its tangent plane on both sides, along any direction.
bool hollow(const tissue::SurfaceDistance& distance, const deformable::SurfaceSite& site, double reach) {
  constexpr int kDirections = 6;
  const Vector3 side = site.normal.unitOrthogonal(), other = site.normal.cross(side);
  for (int k = 0; k < kDirections; ++k) {
    const double angle = std::numbers::pi * k / kDirections;
    const Vector3 way = reach * (std::cos(angle) * side + std::sin(angle) * other);
    const double fallen = distance.at(site.place + way).distance + distance.at(site.place - way).distance;
    if (fallen < -kHollow * reach * reach) return true;
  }
  return false;
}

}  // namespace

std::vector<deformable::SurfaceSite> surface_sites(const scene::TriangleMesh& surface,
                                                   const tissue::SurfaceDistance& distance, double spacing,
                                                   const Vector3& up, double support) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vector3& v : surface.vertices) lowest = std::min(lowest, v.dot(up));
  const auto reached = [&](const Vector3& p) { return p.dot(up) > lowest + support; };
  std::vector<deformable::SurfaceSite> sites;
  const Draw draw(surface, up);
  if (!(draw.area() > 0.0)) return sites;
  const auto drawn =
      std::min(kMostDrawn, static_cast<std::size_t>(std::ceil(kDrawn * draw.area() / (spacing * spacing))));
  const auto take = [&](Random& random, double closest, std::size_t tries, const auto& wanted) {
    Picks picks(closest);
    for (const auto& site : sites) picks.add(site.place);
    for (std::size_t i = 0; i < tries; ++i) {
      const auto site = draw.next(random);
      if (!reached(site.place) || picks.near(site.place) || !wanted(site.place)) continue;
      picks.add(site.place);
      sites.push_back(site);
    }
  };
  Random everywhere(1, "organ/sites");
  take(everywhere, kClosest * spacing, drawn, [](const Vector3&) { return true; });
  Picks hollows(spacing);
  for (const auto& site : sites)
    if (hollow(distance, site, spacing)) hollows.add(site.place);
  Random within(1, "organ/sites in hollows");
  take(within, 0.5 * kClosest * spacing, std::min(kMostDrawn, 4 * drawn),
       [&](const Vector3& p) { return hollows.near(p); });
  return sites;
}

}  // namespace palpate::physics::organ
