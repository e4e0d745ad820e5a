// Meshes on the graphics card, looked up by address, uploaded anew where their version has changed.
// Thread: the context's.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "palpate/render/mesh_buffer.h"
#include "palpate/scene/draw_item.h"
#include "palpate/scene/mesh.h"
#include "palpate/scene/shape.h"

namespace palpate::render {

struct CachedBody {
  std::uint64_t version = 0, last_used = 0;   // of the mesh; picture
  std::shared_ptr<const scene::Shape> shape;  // that it has taken on
  std::shared_ptr<const scene::Tint> tint;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // that `closed` speaks of
  bool closed = false;
  double spacing = 0.0;  // m, of the vertices of a shape without triangles; 0: not known yet
  MeshBuffer buffer;
};

// The tint has a share for each of the mesh's vertices.
bool takes(const scene::TriangleMesh& mesh, const scene::Tint* tint);
// The shape has a place for each of the mesh's vertices. A mesh alone keeps its own.
bool takes(const scene::TriangleMesh& mesh, const scene::Shape* shape);

class BodyCache {
 public:
  // `coarse_cells`: bodies of many triangles have fewer as well (MeshBuffer::draw_coarse), clustered(); 0: none have.
  explicit BodyCache(int coarse_cells = 0) : coarse_cells_(coarse_cells) {}
  // `shape`: how the mesh has deformed, or null. One of another number of vertices does not count. Of a mesh
  // without triangles a small square is drawn at each vertex of the shape. `tint`: goes to the vertices' look.
  const CachedBody& body(const scene::TriangleMesh& mesh,
                         const std::shared_ptr<const scene::Shape>& shape = {},
                         const std::shared_ptr<const scene::Tint>& tint = {});
  // Forgets meshes that have not been drawn for a while: they may be gone. Call once per picture.
  void next_picture();

 private:
  // With a shape or a tint and without are different bodies, as all may stand in one picture. Looked up, never
  // walked in an order that shows.
  std::map<std::tuple<const scene::TriangleMesh*, bool, bool>, CachedBody> bodies_;
  void upload(MeshBuffer& buffer, const ShadedMesh& mesh) const;

  int coarse_cells_;
  std::uint64_t picture_ = 0;
};

}  // namespace palpate::render
