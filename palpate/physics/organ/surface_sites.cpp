#include "palpate/physics/organ/surface_sites.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>

#include "palpate/core/random.h"

namespace palpate::physics::organ {
namespace {

constexpr double kClosest =
    0.84;                        // spacings: a full disc pattern has about the density of a square grid then
constexpr double kDrawn = 30.0;  // points for each square of the spacing
constexpr double kFacesTable = -0.3;  // cosine to the upward direction
constexpr std::size_t kMostDrawn = 2'000'000;

class Picks {
 public:
  explicit Picks(double closest) : closest_(closest) {}

  bool add(const Vector3& p) {
    const auto at = cell(p);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const auto found = cells_.find({at[0] + x, at[1] + y, at[2] + z});
          if (found == cells_.end()) continue;
          for (const Vector3& other : found->second)
            if ((other - p).squaredNorm() < closest_ * closest_) return false;
        }
    cells_[at].push_back(p);
    return true;
  }

 private:
  std::array<int, 3> cell(const Vector3& p) const {
    return {static_cast<int>(std::floor(p.x() / closest_)), static_cast<int>(std::floor(p.y() / closest_)),
            static_cast<int>(std::floor(p.z() / closest_))};
  }
  double closest_;
  std::map<std::array<int, 3>, std::vector<Vector3>> cells_;
};

}  // namespace

std::vector<deformable::SurfaceSite> surface_sites(const scene::TriangleMesh& surface, double spacing,
                                                   const Vector3& up, double support) {
  double lowest = std::numeric_limits<double>::infinity(), area = 0.0;
  for (const Vector3& v : surface.vertices) lowest = std::min(lowest, v.dot(up));
  std::vector<double> up_to;  // area of the triangles to here
  std::vector<Vector3> normals;
  for (const auto& t : surface.triangles) {
    const Vector3& a = surface.vertices[t[0]];
    const Vector3 twice = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a);
    normals.push_back(twice.normalized());
    area += normals.back().dot(up) > kFacesTable ? 0.5 * twice.norm() : 0.0;
    up_to.push_back(area);
  }
  std::vector<deformable::SurfaceSite> sites;
  if (!(area > 0.0)) return sites;
  Picks picks(kClosest * spacing);
  Random random(1, "organ/sites");
  const auto drawn =
      std::min(kMostDrawn, static_cast<std::size_t>(std::ceil(kDrawn * area / (spacing * spacing))));
  for (std::size_t i = 0; i < drawn; ++i) {
    const auto found = std::upper_bound(up_to.begin(), up_to.end() - 1, random.uniform(0.0, area));
    const auto number = static_cast<std::size_t>(found - up_to.begin());
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const auto& t = surface.triangles[number];
    const Vector3& a = surface.vertices[t[0]];
    const Vector3 p = a + u * (surface.vertices[t[1]] - a) + v * (surface.vertices[t[2]] - a);
    if (p.dot(up) > lowest + support && picks.add(p)) sites.push_back({p, normals[number]});
  }
  return sites;
}

}  // namespace palpate::physics::organ
