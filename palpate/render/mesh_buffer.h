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

// The triangles left when the vertices of each cell of a grid, `cells` along the diagonal of their box, become the one
// nearest to the cell's middle: a closed surface stays closed. (Rossignac, Borrel 1993.)
std::vector<std::uint32_t> clustered(const ShadedMesh& mesh, int cells);

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
  // Fewer triangles of the same vertices, for who does not look closely; upload() takes them away.
  void upload_coarse(std::span<const std::uint32_t> indices);
  // Attributes: 0 position, 1 normal, 2 look.
  void draw(int instances = 1) const;
  void draw_coarse(int instances = 1) const;    // all of them where there are no fewer
  const Vector3f& low() const { return low_; }  // bounding box, mesh frame
  const Vector3f& high() const { return high_; }

 private:
  unsigned array_ = 0, buffer_ = 0, indices_ = 0, coarse_ = 0;
  int count_ = 0, coarse_count_ = 0;
  Vector3f low_ = Vector3f::Zero(), high_ = Vector3f::Zero();
};

}  // namespace palpate::render
