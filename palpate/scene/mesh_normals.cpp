#include "palpate/scene/mesh_normals.h"

namespace palpate::scene {

std::vector<Vector3> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Vector3> normals(mesh.vertices.size(), Vector3::Zero());
  for (const auto& t : mesh.triangles) {
    const Vector3& a = mesh.vertices[t[0]];
    const Vector3 area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    for (const auto corner : t) normals[corner] += area;
  }
  for (auto& n : normals) n.normalize();
  return normals;
}

TriangleMesh moved(TriangleMesh mesh, const Quaternion& rotation, const Vector3& translation) {
  for (Vector3& v : mesh.vertices) v = rotation * v + translation;
  mesh.version.raise();
  return mesh;
}

}  // namespace palpate::scene
