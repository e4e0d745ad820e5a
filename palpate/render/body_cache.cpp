#include "palpate/render/body_cache.h"

#include <algorithm>
#include <utility>

namespace palpate::render {
namespace {

// Every edge belongs to two triangles.
bool is_closed(const scene::TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  }
  std::sort(edges.begin(), edges.end());
  for (const auto& [a, b] : edges) {
    if (!std::binary_search(edges.begin(), edges.end(), std::pair{b, a})) return false;
  }
  return true;
}

}  // namespace

const CachedBody& BodyCache::body(const scene::TriangleMesh& mesh) {
  CachedBody& known = bodies_[&mesh];
  known.last_used = picture_;
  if (known.version == mesh.version.number()) return known;
  known.version = mesh.version.number();
  known.buffer.upload(shaded(mesh));
  // What deforms keeps its triangles, and comparing these is far quicker than looking for open edges.
  if (known.triangles != mesh.triangles) {
    known.triangles = mesh.triangles;
    known.closed = is_closed(mesh);
  }
  return known;
}

void BodyCache::next_picture() {
  constexpr std::uint64_t kKept = 256;  // pictures
  if (++picture_ % kKept == 0)
    std::erase_if(bodies_, [&](const auto& known) { return known.second.last_used + kKept < picture_; });
}

}  // namespace palpate::render
