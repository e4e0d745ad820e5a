#include "palpate/scene/mesh.h"

#include <atomic>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace palpate::scene {
namespace {

std::uint32_t add(TriangleMesh& mesh, const Vector3& v) {
  mesh.vertices.push_back(v);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

// Closed right prism over a regular polygon: `centre` +- half along u x v, radius along u and v.
TriangleMesh prism(const Vector3& low, const Vector3& high, const Vector3& u, const Vector3& v,
                   int segments) {
  if (segments < 3) throw std::invalid_argument("mesh: a round shape needs at least 3 segments");
  TriangleMesh mesh;
  const auto bottom = add(mesh, low), top = add(mesh, high);
  const auto n = static_cast<std::uint32_t>(segments);
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    const Vector3 rim = std::cos(angle) * u + std::sin(angle) * v;
    add(mesh, low + rim);
    add(mesh, high + rim);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % n);  // on the bottom; the top ones follow them
    mesh.triangles.push_back({bottom, b, a});
    mesh.triangles.push_back({top, a + 1, b + 1});
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
  }
  return mesh;
}

}  // namespace

std::uint64_t MeshVersion::next() noexcept {
  static std::atomic<std::uint64_t> newest{0};
  return newest.fetch_add(1, std::memory_order_relaxed) + 1;
}

TriangleMesh rectangle_mesh(const Vector3& corner, const Vector3& side_x, const Vector3& side_y) {
  return {{corner, corner + side_x, corner + side_x + side_y, corner + side_y}, {{0, 1, 2}, {0, 2, 3}}};
}

TriangleMesh disc_mesh(double radius, double thickness, int segments) {
  const Vector3 half(0.0, 0.5 * thickness, 0.0);
  return prism(-half, half, radius * Vector3::UnitZ(), radius * Vector3::UnitX(), segments);
}

TriangleMesh sphere_mesh(double radius, int rings, int segments) {
  if (rings < 2 || segments < 3) throw std::invalid_argument("mesh: a sphere needs 2 rings and 3 segments");
  TriangleMesh mesh;
  const auto south = add(mesh, {0.0, -radius, 0.0}), north = add(mesh, {0.0, radius, 0.0});
  const auto n = static_cast<std::uint32_t>(segments), m = static_cast<std::uint32_t>(rings);
  for (std::uint32_t r = 1; r < m; ++r) {  // circles of latitude, south to north
    const double latitude = std::numbers::pi * (static_cast<double>(r) / m - 0.5);
    for (std::uint32_t i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / n;
      add(mesh, radius * Vector3(std::cos(latitude) * std::sin(angle), std::sin(latitude),
                                 std::cos(latitude) * std::cos(angle)));
    }
  }
  const auto at = [&](std::uint32_t r, std::uint32_t i) { return 2 + (r - 1) * n + i % n; };
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh.triangles.push_back({south, at(1, i + 1), at(1, i)});
    mesh.triangles.push_back({north, at(m - 1, i), at(m - 1, i + 1)});
    for (std::uint32_t r = 1; r + 1 < m; ++r) {
      mesh.triangles.push_back({at(r, i), at(r, i + 1), at(r + 1, i + 1)});
      mesh.triangles.push_back({at(r, i), at(r + 1, i + 1), at(r + 1, i)});
    }
  }
  return mesh;
}

TriangleMesh cylinder_mesh(const Vector3& a, const Vector3& b, double radius, int segments) {
  const Vector3 axis = b - a;
  if (axis.norm() < 1e-12) throw std::invalid_argument("mesh: a cylinder's two ends coincide");
  const Vector3 u = axis.unitOrthogonal();
  const Vector3 v = axis.normalized().cross(u);
  return prism(a, b, radius * u, radius * v, segments);
}

TriangleMesh ring_mesh(double radius, double wire_radius, int segments) {
  if (segments < 3) throw std::invalid_argument("mesh: a ring needs 3 segments");
  const auto at = [&](int i) -> Vector3 {
    const double angle = 2.0 * std::numbers::pi * (i % segments) / segments;
    return radius * Vector3(std::cos(angle), 0.0, std::sin(angle));
  };
  TriangleMesh mesh;
  for (int i = 0; i < segments; ++i) append(mesh, cylinder_mesh(at(i), at(i + 1), wire_radius, 8));
  return mesh;
}

TriangleMesh box_mesh(const Vector3& low, const Vector3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {  // bit 0 = x, 1 = y, 2 = z
    add(mesh, {(i & 1 ? high : low).x(), (i & 2 ? high : low).y(), (i & 4 ? high : low).z()});
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  const std::size_t count = other.triangles.size();  // `other` may be `mesh` itself
  const std::size_t vertices = other.vertices.size();
  mesh.vertices.reserve(mesh.vertices.size() + vertices);
  mesh.triangles.reserve(mesh.triangles.size() + count);
  for (std::size_t i = 0; i < vertices; ++i) mesh.vertices.push_back(Vector3(other.vertices[i]));
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = other.triangles[i];
    mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
  mesh.version.raise();
}

}  // namespace palpate::scene
