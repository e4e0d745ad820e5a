#include "palpate/render/mesh_buffer.h"

#include <epoxy/gl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

namespace palpate::render {

std::vector<std::uint32_t> clustered(const ShadedMesh& mesh, int cells) {
  if (mesh.vertices.empty() || cells < 1) return mesh.indices;
  Eigen::AlignedBox3f box;
  for (const ShadedVertex& vertex : mesh.vertices) box.extend(Vector3f(vertex.position));
  const float side = std::max(box.diagonal().norm() / static_cast<float>(cells), 1e-9f);
  struct Kept {
    std::uint32_t vertex;
    float distance;
  };
  std::map<std::array<int, 3>, Kept> kept;
  const auto cell_of = [&](const Vector3f& p) {
    const Vector3f c = ((p - box.min()) / side).array().floor();
    return std::array{static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z())};
  };
  std::vector<const Kept*> of_vertex;
  of_vertex.reserve(mesh.vertices.size());
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3f p(mesh.vertices[i].position);
    const auto cell = cell_of(p);
    const Vector3f middle = box.min() + side * (Vector3f(cell[0], cell[1], cell[2]).array() + 0.5f).matrix();
    const float distance = (p - middle).squaredNorm();
    Kept& best = kept.try_emplace(cell, Kept{i, distance}).first->second;
    if (distance < best.distance) best = {i, distance};
    of_vertex.push_back(&best);
  }
  std::vector<std::uint32_t> indices;
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const std::uint32_t a = of_vertex[mesh.indices[t]]->vertex, b = of_vertex[mesh.indices[t + 1]]->vertex,
                        c = of_vertex[mesh.indices[t + 2]]->vertex;
    if (a != b && b != c && c != a) indices.insert(indices.end(), {a, b, c});
  }
  return indices;
}

ShadedMesh shaded(const scene::TriangleMesh& mesh, double crease_deg) {
  const std::size_t count = mesh.vertices.size();
  // Vertices at the same place count as one (seams of spheres and cylinders are written twice).
  std::vector<std::uint32_t> order(count), place(count);
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const Vector3 &p = mesh.vertices[a], &q = mesh.vertices[b];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    if (p.z() != q.z()) return p.z() < q.z();
    return a < b;
  };
  std::sort(order.begin(), order.end(), before);
  for (std::size_t i = 0; i < count; ++i) {
    const bool same = i > 0 && mesh.vertices[order[i]] == mesh.vertices[order[i - 1]];
    place[order[i]] = same ? place[order[i - 1]] : order[i];
  }
  // Faces round each place, as one list with a start per place.
  std::vector<std::uint32_t> start(count + 1, 0);
  for (const auto& triangle : mesh.triangles) {
    for (const auto v : triangle) ++start[place[v] + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::uint32_t> faces(start.back()), filled(start.begin(), start.end() - 1);
  std::vector<Vector3> area(mesh.triangles.size());  // normal times twice the area
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    area[t] = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    for (const auto v : mesh.triangles[t]) faces[filled[place[v]]++] = t;
  }
  const double smooth = std::cos(crease_deg * std::numbers::pi / 180.0);
  ShadedMesh result;
  result.indices.reserve(3 * mesh.triangles.size());
  constexpr std::uint32_t none = ~0u;
  std::vector<std::uint32_t> first(count, none), next;  // chain of the vertices made for a place
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const double own = area[t].norm();
    for (const auto v : mesh.triangles[t]) {
      const std::uint32_t at = place[v];
      // Always summed in the same order, so that faces with the same neighbours get the same bits.
      Vector3 normal = Vector3::Zero();
      for (auto i = start[at]; i < start[at + 1]; ++i) {
        const Vector3& other = area[faces[i]];
        if (faces[i] == t || other.dot(area[t]) > smooth * own * other.norm()) normal += other;
      }
      const double length = normal.norm();
      if (length > 0) normal /= length;
      const Vector3f p = mesh.vertices[at].cast<float>(), n = normal.cast<float>();
      std::uint32_t vertex = first[at];
      while (vertex != none && Vector3f(result.vertices[vertex].normal) != n) vertex = next[vertex];
      if (vertex == none) {
        vertex = static_cast<std::uint32_t>(result.vertices.size());
        result.vertices.push_back({{p.x(), p.y(), p.z()}, {n.x(), n.y(), n.z()}});
        result.from.push_back(v);
        next.push_back(first[at]);
        first[at] = vertex;
      }
      result.indices.push_back(vertex);
    }
  }
  return result;
}

MeshBuffer::MeshBuffer() {
  glGenVertexArrays(1, &array_);
  glGenBuffers(1, &buffer_);
  glGenBuffers(1, &indices_);
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  for (unsigned attribute = 0; attribute < 3; ++attribute) glEnableVertexAttribArray(attribute);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(ShadedVertex), nullptr);
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(ShadedVertex),
                        reinterpret_cast<const void*>(offsetof(ShadedVertex, normal)));
  glVertexAttribPointer(2, 1, GL_FLOAT, GL_FALSE, sizeof(ShadedVertex),
                        reinterpret_cast<const void*>(offsetof(ShadedVertex, look)));
}
MeshBuffer::MeshBuffer(const scene::TriangleMesh& mesh, double crease_deg) : MeshBuffer() {
  upload(shaded(mesh, crease_deg));
}
MeshBuffer::~MeshBuffer() {
  if (array_ != 0) glDeleteVertexArrays(1, &array_);
  if (buffer_ != 0) glDeleteBuffers(1, &buffer_);
  if (indices_ != 0) glDeleteBuffers(1, &indices_);
  if (coarse_ != 0) glDeleteBuffers(1, &coarse_);
}
MeshBuffer::MeshBuffer(MeshBuffer&& other) noexcept { *this = std::move(other); }
MeshBuffer& MeshBuffer::operator=(MeshBuffer&& other) noexcept {
  std::swap(array_, other.array_);
  std::swap(buffer_, other.buffer_);
  std::swap(indices_, other.indices_);
  std::swap(coarse_, other.coarse_);
  std::swap(count_, other.count_);
  std::swap(coarse_count_, other.coarse_count_);
  std::swap(low_, other.low_);
  std::swap(high_, other.high_);
  return *this;
}

void MeshBuffer::upload(const ShadedMesh& mesh) {
  glBindVertexArray(array_);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(std::uint32_t)),
               mesh.indices.data(), GL_STATIC_DRAW);
  count_ = static_cast<int>(mesh.indices.size());
  coarse_count_ = 0;
  upload_vertices(mesh.vertices);
}

void MeshBuffer::upload_vertices(std::span<const ShadedVertex> vertices) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(),
               GL_DYNAMIC_DRAW);
  low_ = high_ = Vector3f::Zero();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vector3f p(vertices[i].position);
    low_ = i == 0 ? p : Vector3f(low_.cwiseMin(p));
    high_ = i == 0 ? p : Vector3f(high_.cwiseMax(p));
  }
}

void MeshBuffer::upload_coarse(std::span<const std::uint32_t> indices) {
  if (coarse_ == 0) glGenBuffers(1, &coarse_);
  glBindVertexArray(array_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, coarse_);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size_bytes()), indices.data(),
               GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  coarse_count_ = static_cast<int>(indices.size());
}

void MeshBuffer::draw_coarse(int instances) const {
  if (coarse_count_ == 0) return draw(instances);
  glBindVertexArray(array_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, coarse_);
  glDrawElementsInstanced(GL_TRIANGLES, coarse_count_, GL_UNSIGNED_INT, nullptr, instances);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
}

void MeshBuffer::draw(int instances) const {
  if (count_ == 0) return;
  glBindVertexArray(array_);
  glDrawElementsInstanced(GL_TRIANGLES, count_, GL_UNSIGNED_INT, nullptr, instances);
}

}  // namespace palpate::render
