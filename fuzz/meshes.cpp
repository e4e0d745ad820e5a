// Mesh files through reader and repair, and what comes of them under a ball.
#include "fuzz/check.h"
#include "palpate/physics/sweep.h"
#include "palpate/scene/mesh_file.h"

namespace palpate::fuzz {

Refusals meshes(std::string_view file) {
  Refusals refusals;
  const auto read = scene::parse_mesh(file, "mesh.stl", 0.001);
  if (!answered(read, refusals)) return refusals;
  const auto& mesh = read->mesh;
  hold(!mesh.triangles.empty(), "a mesh that was read has triangles");
  double size = 0.0;
  for (const auto& v : mesh.vertices) {
    hold_finite(v, "vertices are finite");
    size = std::max(size, v.norm());
  }
  for (const auto& t : mesh.triangles)
    for (const auto corner : t) hold(corner < mesh.vertices.size(), "a triangle's corners are there");
  auto again = mesh;
  const auto report = scene::repair(again);
  hold(report.welded_vertices + report.dropped_triangles + report.repeated_triangles == 0,
       "what was repaired needs no repair");
  const physics::CollisionMesh prepared(mesh);
  const auto& t = mesh.triangles.front();
  const Vector3 aim = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
  const Vector3 from = aim + Vector3(0.3, 2.0, 0.5) * (size + 0.001), to = 2.0 * aim - from;
  const double radius = 0.1 * (size + 0.001);
  const auto hit = prepared.sweep(from, to, radius);
  hold(hit.has_value(), "a ball thrown at a triangle touches something");
  hold(hit->fraction >= 0.0 && hit->fraction <= 1.0, "a touch lies within the motion");
  hold(std::abs(hit->normal.norm() - 1.0) < 1e-9 && hit->point.allFinite(), "a touch has a unit normal");
  return refusals;
}

}  // namespace palpate::fuzz
