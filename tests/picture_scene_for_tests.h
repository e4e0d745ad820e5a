// Table, wall, arm, ball and bat as the tests of the augmented picture use them, and rays through them.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "palpate/math/looking.h"
#include "palpate/render/arm_shape.h"
#include "palpate/render/compositor.h"

namespace palpate {

inline const device::CameraModel kTestCamera{640, 480, 560, 561.5, 318.7, 242.1, {}};
inline constexpr double kTableHeight = -1.52;  // m, World

// What tests tell colours of a picture apart by.
inline constexpr scene::Look kOrange{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kRed{{0.42f, 0.020f, 0.018f}, 0.015f, 0.12f, 0.06f};
inline constexpr scene::Look kGreen{{0.16f, 0.62f, 0.22f}, 0.030f, 0.20f, 0.20f};

inline const Pose<World, CameraOptical> kTestEye = looking({0, -0.95, 2.30}, {0, -1.45, 1.40});

inline device::CameraImage even_image(const device::CameraModel& camera, std::uint8_t level) {
  device::CameraImage image;
  image.width = camera.width, image.height = camera.height;
  image.rgb.assign(3 * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height),
                   level);
  return image;
}

inline render::RealScene real_scene(bool with_arm) {
  render::RealScene real;
  real.surfaces = {
      {"table",
       {Vector3(-0.375, -1.52, 1.8), {0.375, -1.52, 1.8}, {0.375, -1.52, 0.8}, {-0.375, -1.52, 0.8}}},
      {"wall",
       {Vector3(-0.375, -1.52, 0.8), {0.375, -1.52, 0.8}, {0.375, -0.92, 0.8}, {-0.375, -0.92, 0.8}}}};
  if (with_arm) {
    render::ArmConfiguration arm;
    arm.X_world_base = {Quaternion::Identity(), {0.10, -1.40, 1.75}};
    arm.theta = {0.1, 0.3, 0.2};
    real.arm = arm;
  }
  return real;
}

inline scene::DrawItem item_at(const scene::TriangleMesh& mesh, const Vector3& place,
                               const scene::Look& look = kOrange) {
  scene::DrawItem item;
  item.mesh = &mesh;
  item.position = place;
  item.look = look;
  return item;
}

inline scene::DrawItem sphere_at(const scene::TriangleMesh& mesh, double radius, const Vector3& place) {
  scene::DrawItem item = item_at(mesh, place);
  item.sphere_radius = radius;
  return item;
}

inline const std::uint8_t* pixel_of(const std::vector<std::uint8_t>& rgb, const device::CameraModel& camera,
                                    int u, int v) {
  return &rgb[static_cast<std::size_t>(3 * (v * camera.width + u))];
}

// Triangles in World, and the nearest hit of a ray: brute force (Moeller and Trumbore 1997).
using Triangles = std::vector<std::array<Vector3, 3>>;

inline Triangles triangles_of(const scene::TriangleMesh& mesh, const Quaternion& R, const Vector3& t) {
  Triangles all;
  for (const auto& f : mesh.triangles)
    all.push_back({R * mesh.vertices[f[0]] + t, R * mesh.vertices[f[1]] + t, R * mesh.vertices[f[2]] + t});
  return all;
}

inline Triangles triangles_of(const render::ArmConfiguration& arm, double base_below) {
  const auto poses = render::arm_part_poses(arm.lengths, arm.theta, arm.gimbal, arm.X_tip_marker);
  Triangles all;
  for (const auto& part :
       render::arm_parts(arm.lengths, {.base_below = base_below, .leds = {}, .segments = 20})) {
    const auto X = arm.X_world_base * poses[static_cast<std::size_t>(part.frame)];
    const auto placed = triangles_of(part.mesh, X.rotation, X.translation);
    all.insert(all.end(), placed.begin(), placed.end());
  }
  return all;
}

inline double nearest_hit(const Triangles& triangles, const Vector3& from, const Vector3& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : triangles) {
    const Vector3 e = b - a, f = c - a, p = direction.cross(f);
    const double det = e.dot(p);
    if (std::abs(det) < 1e-14) continue;
    const Vector3 s = from - a;
    const double u = s.dot(p) / det;
    if (u < 0 || u > 1) continue;
    const Vector3 q = s.cross(e);
    const double v = direction.dot(q) / det;
    if (v < 0 || u + v > 1) continue;
    const double t = f.dot(q) / det;
    if (t > 1e-6) nearest = std::min(nearest, t);
  }
  return nearest;
}

// World direction through a pixel of the undistorted picture, z of 1 in front of the camera.
inline Vector3 ray_of(const device::CameraModel& camera, const Pose<World, CameraOptical>& X, double u,
                      double v) {
  return X.rotation * Vector3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
}

}  // namespace palpate
