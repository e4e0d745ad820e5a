// For tests: pictures of dots as a camera on the head takes them, and where an eye sees them in the end.
//
// A dot for each of the three colours, so that one picture has three places that do not mix. Independent of what is
// tested: places are projected by the camera model, found as centroids, and judged by where the eye truly is.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "palpate/headset/headset.h"
#include "test_runtime/test_runtime_for_tests.h"

namespace palpate::headset {

inline constexpr double kDegree = std::numbers::pi / 180.0;

using Dots = std::array<Point<Local>, 3>;  // red, green, blue

// A head that moves steadily, from `begin` at the origin of the runtime's time on.
struct SteadyHead {
  Vector3 spin = Vector3::Zero();      // rad/s, Local's axes
  Vector3 velocity = Vector3::Zero();  // m/s
  std::int64_t begin_ns = 0;

  Pose<Local, View> at(std::int64_t ns) const {
    const double t = 1e-9 * static_cast<double>(ns - begin_ns);
    return {so3_exp(t * spin), Vector3(0.0, 1.6, 0.0) + t * velocity};
  }
  HeadPlace place(std::int64_t ns) const {
    const Pose<Local, View> X = at(ns);
    return {X.translation.x(), X.translation.y(), X.translation.z(), X.rotation.w(),
            X.rotation.x(),    X.rotation.y(),    X.rotation.z()};
  }
};

// Dots as large as a few pixels, so that their centroid is found to a small part of one.
inline void draw_dots(const Dots& dots, const Eye& eye, const Pose<Local, View>& X_local_view, int left,
                      int width, std::vector<std::uint8_t>& rgb) {
  constexpr double kSigma_px = 3.0;
  constexpr int kReach_px = 12;
  const Pose<CameraOptical, Local> X = (X_local_view * eye.X_view_camera).inverse();
  for (std::size_t c = 0; c < dots.size(); ++c) {
    const device::Pixel at = eye.camera.project_undistorted((X * dots[c]).m);
    const int u0 = static_cast<int>(std::lround(at.x())), v0 = static_cast<int>(std::lround(at.y()));
    for (int v = v0 - kReach_px; v <= v0 + kReach_px; ++v)
      for (int u = u0 - kReach_px; u <= u0 + kReach_px; ++u) {
        if (u < 0 || v < 0 || u >= eye.camera.width || v >= eye.camera.height) continue;
        const double r2 = (device::Pixel(u, v) - at).squaredNorm();
        const auto index = 3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(left + u)) +
                           c;
        rgb[index] =
            static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * r2 / (kSigma_px * kSigma_px))));
      }
  }
}

// What the cameras see from there, side by side.
inline std::vector<std::uint8_t> picture_of(const Dots& dots, const std::vector<Eye>& eyes,
                                            const Pose<Local, View>& X_local_view) {
  const int each = eyes.front().camera.width, width = each * static_cast<int>(eyes.size());
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(width) *
                                static_cast<std::size_t>(eyes.front().camera.height) * 3);
  for (std::size_t i = 0; i < eyes.size(); ++i)
    draw_dots(dots, eyes[i], X_local_view, static_cast<int>(i) * each, width, rgb);
  return rgb;
}

// Direction, in View, in which an eye sees a colour's dot; none: it does not.
inline std::optional<Vector3> direction_of(const EyePicture& seen, std::size_t channel,
                                           const TestDisplay& display) {
  double weight = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int row = 0; row < seen.height; ++row)
    for (int column = 0; column < seen.width; ++column) {
      const double w = seen.rgb[3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(seen.width) +
                                     static_cast<std::size_t>(column)) +
                                channel];
      weight += w;
      sum += w * Eigen::Vector2d(column + 0.5, row + 0.5);
    }
  if (weight < 255.0) return std::nullopt;
  const double edge = std::tan(display.half_view);
  const Eigen::Vector2d at = sum / weight;
  return Vector3(edge * (2.0 * at.x() / seen.width - 1.0), edge * (1.0 - 2.0 * at.y() / seen.height), -1.0);
}

// In which it would see the real one.
inline Vector3 true_direction(const Point<Local>& dot, int eye, const Pose<Local, View>& X_local_view,
                              const TestDisplay& display) {
  const Vector3 in_view = (X_local_view.inverse() * dot).m;
  return in_view - Vector3((eye == 0 ? -0.5 : 0.5) * display.eye_distance, 0.0, 0.0);
}

inline double angle_of(const Vector3& a, const Vector3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace palpate::headset
