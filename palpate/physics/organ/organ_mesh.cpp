#include "palpate/physics/organ/organ_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "palpate/physics/deformable/stuffed_mesh.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate::physics::organ {
namespace {

constexpr double kLeastVolume = 0.85;  // of the surface's, that its elements fill at least

double enclosed_volume(const scene::TriangleMesh& surface) {
  double six = 0.0;
  for (const auto& t : surface.triangles)
    six += surface.vertices[t[0]].dot(surface.vertices[t[1]].cross(surface.vertices[t[2]]));
  return six / 6.0;
}

// Whether these places span an area that a body can stand on.
bool carries(const std::vector<Vector3>& held, double element) {
  if (held.empty()) return false;
  Vector3 middle = Vector3::Zero();
  for (const Vector3& p : held) middle += p / static_cast<double>(held.size());
  Vector3 far = Vector3::Zero();
  for (const Vector3& p : held)
    if ((p - middle).norm() > far.norm()) far = p - middle;
  double width = 0.0;
  for (const Vector3& p : held) width = std::max(width, (p - middle).cross(far).norm());
  return width > 0.25 * element * far.norm() && far.norm() > 0.5 * element;
}

}  // namespace

Expected<OrganMesh> organ_mesh(const scene::TriangleMesh& surface, const tissue::SurfaceDistance& distance,
                               double element, const Vector3& up, double support) {
  deformable::StuffedMeshSettings box;
  box.spacing = element;
  box.low = box.high = surface.vertices.front();
  for (const Vector3& v : surface.vertices) box.low = box.low.cwiseMin(v), box.high = box.high.cwiseMax(v);
  auto mesh = deformable::stuffed_mesh([&](const Vector3& p) { return distance.at(p).distance; }, box);
  if (!mesh) return tl::unexpected(mesh.error());
  const double share = deformable::volume(*mesh) / enclosed_volume(surface);
  if (!(share > kLeastVolume))
    return refused(
        "organ: elements of {:.1f} mm fill {:.0f} % of the surface, it is too thin for them; take smaller "
        "ones",
        1e3 * element, 100.0 * share);
  return lay_down(std::move(*mesh), surface, element, up, support);
}

Expected<OrganMesh> lay_down(deformable::TetMesh mesh, const scene::TriangleMesh& surface, double element,
                             const Vector3& up, double support) {
  OrganMesh organ{std::move(mesh), deformable::FreeMotion({}), {}};
  organ.motion = deformable::FreeMotion(organ.mesh);
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vector3& v : surface.vertices) lowest = std::min(lowest, v.dot(up));
  std::vector<Vector3> held;
  for (std::size_t n = 0; n < organ.mesh.nodes.size(); ++n)
    if (organ.mesh.nodes[n].dot(up) < lowest + support) {
      organ.motion.hold(static_cast<int>(n));
      held.push_back(organ.mesh.nodes[n]);
    }
  organ.motion.number();
  if (!carries(held, element))
    return refused(
        "organ: {} nodes of its mesh rest on the table, which does not hold it; take smaller elements or "
        "more support",
        held.size());
  for (const auto& facet : organ.mesh.facets)
    organ.surface_nodes.insert(organ.surface_nodes.end(), facet.begin(), facet.end());
  std::sort(organ.surface_nodes.begin(), organ.surface_nodes.end());
  organ.surface_nodes.erase(std::unique(organ.surface_nodes.begin(), organ.surface_nodes.end()),
                            organ.surface_nodes.end());
  return organ;
}

}  // namespace palpate::physics::organ
