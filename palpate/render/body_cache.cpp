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

// A shape brings its own normals: nothing is split at creases.
std::vector<ShadedVertex> vertices_of(const scene::Shape& shape) {
  std::vector<ShadedVertex> vertices(shape.vertices());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const float* values = &shape.values[i * scene::Shape::kFloatsPerVertex];
    std::copy_n(values, 3, vertices[i].position);
    std::copy_n(values + 3, 3, vertices[i].normal);
  }
  return vertices;
}

std::vector<std::uint32_t> indices_of(const scene::TriangleMesh& mesh) {
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) indices.insert(indices.end(), triangle.begin(), triangle.end());
  return indices;
}

}  // namespace

bool takes(const scene::TriangleMesh& mesh, const scene::Shape* shape) {
  return shape != nullptr && shape->vertices() == mesh.vertices.size();
}

const CachedBody& BodyCache::body(const scene::TriangleMesh& mesh,
                                  const std::shared_ptr<const scene::Shape>& shape) {
  const bool deformed = takes(mesh, shape.get());
  CachedBody& known = bodies_[{&mesh, deformed}];
  known.last_used = picture_;
  const bool same_mesh = known.version == mesh.version.number();
  if (same_mesh && (!deformed || known.shape == shape)) return known;
  known.version = mesh.version.number();
  if (!deformed)
    known.buffer.upload(shaded(mesh));
  else if (same_mesh)
    known.buffer.upload_vertices(vertices_of(*shape));
  else
    known.buffer.upload({vertices_of(*shape), indices_of(mesh)});
  if (deformed) known.shape = shape;
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
