// Meshes on the graphics card, looked up by address; one that changes its shape in place is seen to change.
// Thread: the context's.
#pragma once

#include <cstdint>
#include <map>

#include "palpate/render/mesh_buffer.h"
#include "palpate/scene/mesh.h"

namespace palpate::render {

struct CachedBody {
  std::uint64_t topology = 0, shape = 0, last_used = 0;
  bool closed = false;
  MeshBuffer buffer;
  // Radius where the mesh's box is a cube, so that it may be taken for a ball; else 0. m.
  double ball_radius() const;
};

class BodyCache {
 public:
  const CachedBody& body(const scene::TriangleMesh& mesh);
  // Forgets meshes that have not been drawn for a while: they may be gone, and their address may come back as
  // another mesh. Call once per picture.
  void next_picture();

 private:
  std::map<const scene::TriangleMesh*, CachedBody> bodies_;  // looked up, never walked in an order that shows
  std::uint64_t picture_ = 0;
};

}  // namespace palpate::render
