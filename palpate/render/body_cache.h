// Meshes on the graphics card, looked up by address, uploaded anew where their version has changed.
// Thread: the context's.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "palpate/render/mesh_buffer.h"
#include "palpate/scene/mesh.h"

namespace palpate::render {

struct CachedBody {
  std::uint64_t version = 0, last_used = 0;             // of the mesh; picture
  std::vector<std::array<std::uint32_t, 3>> triangles;  // that `closed` speaks of
  bool closed = false;
  MeshBuffer buffer;
};

class BodyCache {
 public:
  const CachedBody& body(const scene::TriangleMesh& mesh);
  // Forgets meshes that have not been drawn for a while: they may be gone. Call once per picture.
  void next_picture();

 private:
  std::map<const scene::TriangleMesh*, CachedBody> bodies_;  // looked up, never walked in an order that shows
  std::uint64_t picture_ = 0;
};

}  // namespace palpate::render
