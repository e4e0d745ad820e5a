#include "palpate/render/body_cache.h"

#include <algorithm>
#include <cstring>

namespace palpate::render {
namespace {

std::uint64_t content_key(const void* data, std::size_t bytes) {
  std::uint64_t h = 1469598103934665603ull;
  const auto* at = static_cast<const unsigned char*>(data);
  for (; bytes >= 8; bytes -= 8, at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, at, 8);
    h = (h ^ word) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
  }
  for (; bytes > 0; --bytes, ++at) h = (h ^ *at) * 1099511628211ull;
  return h;
}

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

double CachedBody::ball_radius() const {
  const Vector3f sides = buffer.high() - buffer.low();
  const bool cube = sides.maxCoeff() - sides.minCoeff() < 0.02f * sides.maxCoeff();
  return cube && closed ? 0.5 * static_cast<double>(sides.mean()) : 0.0;
}

const CachedBody& BodyCache::body(const scene::TriangleMesh& mesh) {
  CachedBody& known = bodies_[&mesh];
  known.last_used = picture_;
  const auto topology =
      content_key(mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0])) + 1;
  const auto shape = content_key(mesh.vertices.data(), mesh.vertices.size() * sizeof(mesh.vertices[0])) + 1;
  if (known.topology != topology || known.shape != shape) {
    const ShadedMesh shaded = render::shaded(mesh);
    if (known.topology != topology) known.closed = is_closed(mesh);
    known.buffer.upload(shaded);
    known.topology = topology;
    known.shape = shape;
  }
  return known;
}

void BodyCache::next_picture() {
  constexpr std::uint64_t kKept = 256;  // pictures
  if (++picture_ % kKept == 0)
    std::erase_if(bodies_, [&](const auto& known) { return known.second.last_used + kKept < picture_; });
}

}  // namespace palpate::render
