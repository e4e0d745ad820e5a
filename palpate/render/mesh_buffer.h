// A triangle mesh on the graphics card, with normals made from its faces.
//
// Faces that meet at less than the crease angle share a smooth normal; sharper edges stay sharp. Mesh frame,
// metres. Thread: the context's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpate/render/gl_objects.h"
#include "palpate/scene/mesh.h"

namespace palpate::render {

struct ShadedVertex {
  float position[3];
  float normal[3];
  float look = 0.0f;  // which of its looks a body of several shows here; of one with a tint its share
};

struct ShadedMesh {
  std::vector<ShadedVertex> vertices;
  std::vector<std::uint32_t> indices;  // three per triangle
  std::vector<std::uint32_t> from{};   // the mesh's vertex of each of these; empty: the same
};

// Areas weigh the normals.
ShadedMesh shaded(const scene::TriangleMesh& mesh, double crease_deg = 40.0);

class MeshBuffer {
 public:
  MeshBuffer();
  explicit MeshBuffer(const scene::TriangleMesh& mesh, double crease_deg = 40.0);
  ~MeshBuffer();
  MeshBuffer(MeshBuffer&& other) noexcept;
  MeshBuffer& operator=(MeshBuffer&& other) noexcept;

  void upload(const ShadedMesh& mesh);
  void upload_vertices(std::span<const ShadedVertex> vertices);  // as many as before
  // Attributes: 0 position, 1 normal, 2 look.
  void draw(int instances = 1) const;
  const Vector3f& low() const { return low_; }  // bounding box, mesh frame
  const Vector3f& high() const { return high_; }

 private:
  unsigned array_ = 0, buffer_ = 0, indices_ = 0;
  int count_ = 0;
  Vector3f low_ = Vector3f::Zero(), high_ = Vector3f::Zero();
};

}  // namespace palpate::render
