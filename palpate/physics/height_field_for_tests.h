// Surfaces on which tests and benchmarks let tips slide and balls fly. For those only.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "palpate/core/random.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics {

// z = A sin(2 pi x / 40 mm) cos(2 pi y / 50 mm), flat for A = 0.
struct Bumps {
  double amplitude = 0.005;  // m
  double height(double x, double y) const {
    return amplitude * std::sin(2.0 * std::numbers::pi * x / 0.040) *
           std::cos(2.0 * std::numbers::pi * y / 0.050);
  }
};

// The square |x|, |y| <= side / 2 in cells x cells squares of two triangles, facing +z.
inline scene::TriangleMesh height_field(const Bumps& bumps, std::uint32_t cells, double side = 0.2) {
  scene::TriangleMesh mesh;
  const double step = side / cells;
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) {
      const double x = -0.5 * side + i * step, y = -0.5 * side + j * step;
      mesh.vertices.emplace_back(x, y, bumps.height(x, y));
    }
  }
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

// The square |x|, |z| <= 1 m in side x side squares of two triangles, facing +y; each vertex stands out or in
// by up to `bump`.
inline scene::TriangleMesh rough_field(std::uint32_t side, double bump, Random& random) {
  scene::TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= side; ++i)
    for (std::uint32_t j = 0; j <= side; ++j)
      mesh.vertices.push_back({2.0 * j / side - 1.0, random.uniform(-bump, bump), 2.0 * i / side - 1.0});
  for (std::uint32_t i = 0; i < side; ++i) {
    for (std::uint32_t j = 0; j < side; ++j) {
      const std::uint32_t a = i * (side + 1) + j, b = a + side + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  return mesh;
}

// Where the piecewise flat surface really is: its height over (x, y), by the triangle that holds it.
inline double flat_height(const scene::TriangleMesh& mesh, std::uint32_t cells, double x, double y,
                          double side = 0.2) {
  const double u = (x / side + 0.5) * cells, v = (y / side + 0.5) * cells;
  const double i = std::clamp(std::floor(u), 0.0, cells - 1.0),
               j = std::clamp(std::floor(v), 0.0, cells - 1.0);
  const double s = u - i, t = v - j;
  const auto a = static_cast<std::uint32_t>(j) * (cells + 1) + static_cast<std::uint32_t>(i);
  const auto z = [&](std::uint32_t k) { return mesh.vertices[k].z(); };
  const std::uint32_t c = a + cells + 1;
  return s >= t ? z(a) + s * (z(a + 1) - z(a)) + t * (z(c + 1) - z(a + 1))
                : z(a) + t * (z(c) - z(a)) + s * (z(c + 1) - z(c));
}

// Back and forth in x at `speed`, drifting in y, `depth` under the surface.
inline Vector3 tip_under(const Bumps& bumps, double speed, double depth, double t) {
  constexpr double kReach = 0.080, kDrift = 0.004;  // m, m/s
  const double along = std::fmod(speed * t, 4.0 * kReach);
  const double x = along < 2.0 * kReach ? along - kReach : 3.0 * kReach - along;
  const double y = -0.070 + std::fmod(kDrift * t, 0.140);
  return {x, y, bumps.height(x, y) - depth};
}

}  // namespace palpate::physics
