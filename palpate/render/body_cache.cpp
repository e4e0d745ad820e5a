#include "palpate/render/body_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace palpate::render {
namespace {

// Side of a square over the spacing of the vertices: the disc in it still leaves no gaps where the surface is
// stretched by half.
constexpr double kOverlap = 2.0;

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

// How far vertices lie apart, m: the median over some of them of the distance to the nearest other one.
double spacing_of(const scene::Shape& shape) {
  constexpr std::size_t kAsked = 64;
  const auto place = [&](std::size_t i) {
    return Vector3f(&shape.values[i * scene::Shape::kFloatsPerVertex]);
  };
  const std::size_t count = shape.vertices(), step = std::max<std::size_t>(1, count / kAsked);
  std::vector<float> nearest;
  for (std::size_t i = 0; i < count; i += step) {
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t k = 0; k < count; ++k)
      if (k != i) least = std::min(least, (place(k) - place(i)).squaredNorm());
    if (std::isfinite(least)) nearest.push_back(std::sqrt(least));
  }
  if (nearest.empty()) return 0.0;
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return *middle;
}

// A surface whose triangles are not known: a square at each vertex, across its normal, with `side` as its side.
ShadedMesh squares_of(const scene::Shape& shape, double side) {
  ShadedMesh mesh;
  for (std::uint32_t i = 0; i < shape.vertices(); ++i) {
    const float* values = &shape.values[i * scene::Shape::kFloatsPerVertex];
    const Vector3f p(values), given(values + 3);
    const Vector3f n = given.norm() > 0.0f ? Vector3f(given.normalized()) : Vector3f(Vector3f::UnitY());
    const Vector3f x = 0.5f * static_cast<float>(side) * n.unitOrthogonal(), y = n.cross(x);
    for (const Vector3f& corner :
         {Vector3f(p - x - y), Vector3f(p + x - y), Vector3f(p + x + y), Vector3f(p - x + y)})
      mesh.vertices.push_back({{corner.x(), corner.y(), corner.z()}, {n.x(), n.y(), n.z()}});
    for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(4 * i + corner);
  }
  return mesh;
}

std::vector<std::uint32_t> indices_of(const scene::TriangleMesh& mesh) {
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) indices.insert(indices.end(), triangle.begin(), triangle.end());
  return indices;
}

ShadedMesh with_tint(ShadedMesh mesh, const scene::Tint* tint) {
  if (tint == nullptr) return mesh;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.vertices[i].look = tint->shares[mesh.from.empty() ? i : mesh.from[i]];
  return mesh;
}

}  // namespace

bool takes(const scene::TriangleMesh& mesh, const scene::Shape* shape) {
  return shape != nullptr && shape->vertices() == mesh.vertices.size();
}

bool takes(const scene::TriangleMesh& mesh, const scene::Tint* tint) {
  return tint != nullptr && tint->shares.size() == mesh.vertices.size();
}

const CachedBody& BodyCache::body(const scene::TriangleMesh& mesh,
                                  const std::shared_ptr<const scene::Shape>& shape,
                                  const std::shared_ptr<const scene::Tint>& tint) {
  const bool deformed = takes(mesh, shape.get()), tinted = takes(mesh, tint.get());
  CachedBody& known = bodies_[{&mesh, deformed, tinted}];
  known.last_used = picture_;
  const bool same_mesh = known.version == mesh.version.number();
  const bool same_tint = !tinted || known.tint == tint;
  if (same_mesh && same_tint && (!deformed || known.shape == shape)) return known;
  known.version = mesh.version.number();
  const scene::Tint* shares = tinted ? tint.get() : nullptr;
  if (!deformed) {
    upload(known.buffer, with_tint(shaded(mesh), shares));
  } else if (mesh.triangles.empty()) {
    if (known.spacing == 0.0) known.spacing = spacing_of(*shape);
    known.buffer.upload(squares_of(*shape, kOverlap * known.spacing));
  } else if (same_mesh) {
    known.buffer.upload_vertices(with_tint({vertices_of(*shape), {}}, shares).vertices);
  } else {
    upload(known.buffer, with_tint({vertices_of(*shape), indices_of(mesh)}, shares));
  }
  if (deformed) known.shape = shape;
  if (tinted) known.tint = tint;
  // What deforms keeps its triangles, and comparing these is far quicker than looking for open edges.
  if (known.triangles != mesh.triangles) {
    known.triangles = mesh.triangles;
    known.closed = is_closed(mesh);
  }
  return known;
}

void BodyCache::upload(MeshBuffer& buffer, const ShadedMesh& mesh) const {
  buffer.upload(mesh);
  constexpr std::size_t kMany = 3000;  // triangles
  if (coarse_cells_ > 0 && mesh.indices.size() > 3 * kMany)
    buffer.upload_coarse(clustered(mesh, coarse_cells_));
}

void BodyCache::next_picture() {
  constexpr std::uint64_t kKept = 256;  // pictures
  if (++picture_ % kKept == 0)
    std::erase_if(bodies_, [&](const auto& known) { return known.second.last_used + kKept < picture_; });
}

}  // namespace palpate::render
