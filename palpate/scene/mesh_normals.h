// Normals of a mesh, and a mesh at another place. Pure.
#pragma once

#include <vector>

#include "palpate/scene/mesh.h"

namespace palpate::scene {

// Unit normals of the vertices, weighted by the triangles' areas; of a vertex without any, zero.
std::vector<Vector3> vertex_normals(const TriangleMesh& mesh);

// The same mesh, turned and then shifted.
TriangleMesh moved(TriangleMesh mesh, const Quaternion& rotation, const Vector3& translation);

}  // namespace palpate::scene
