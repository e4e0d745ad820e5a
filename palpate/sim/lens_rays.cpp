#include "palpate/sim/lens_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::sim {
namespace {

constexpr double kNear = 0.01;  // m; nearer than this nothing is looked for

// The largest radius up to which the lens model keeps growing.
double growing_radius(const device::CameraModel& lens) {
  if (lens.kind == device::LensKind::fisheye) {
    constexpr double kStep = 0.01;  // rad
    double angle = kStep, before = 0.0;
    for (; angle < device::kWidestAngle; angle += kStep) {
      const double seen = lens.distort({std::tan(angle), 0.0}).x();
      if (seen - before < 0.05 * kStep) break;
      before = seen;
    }
    return std::tan(angle - kStep);
  }
  constexpr double kStep = 0.01;
  device::CameraModel straight = lens;  // without what is not the same all around
  straight.distortion[2] = straight.distortion[3] = 0.0;
  double r = kStep, before = 0.0;
  for (; r < 3.0; r += kStep) {
    const double seen = straight.distort({r, 0.0}).x();
    if (seen - before < 0.05 * kStep) break;
    before = seen;
  }
  return r - kStep;
}

}  // namespace

LensRays lens_rays(const device::CameraModel& lens) {
  LensRays rays;
  rays.ray.reserve(static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height));
  rays.low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
  rays.high = -rays.low;
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      const auto n = lens.undistort({(u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy});
      rays.ray.push_back(n ? Eigen::Vector2f(n->cast<float>()) : Eigen::Vector2f(1e3f, 1e3f));
      if (!n) continue;
      rays.low = rays.low.cwiseMin(*n);
      rays.high = rays.high.cwiseMax(*n);
    }
  }
  return rays;
}

std::array<int, 4> pixel_box(const device::CameraModel& lens, const std::vector<Vector3>& polygon) {
  const double limit = growing_radius(lens);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max()), high = -low;
  const auto take = [&](const Vector3& p) {
    Eigen::Vector2d n(p.x() / p.z(), p.y() / p.z());
    const double r = n.norm();
    Eigen::Vector2d m =
        r > limit ? Eigen::Vector2d(lens.distort(n * (limit / r)) * (r / limit)) : lens.distort(n);
    const Eigen::Vector2d pixel(lens.fx * m.x() + lens.cx, lens.fy * m.y() + lens.cy);
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    constexpr int kSteps = 24;  // a bent edge differs from its chords by less than the border below
    double begin = 0.0, end = 1.0;
    if (a.z() < kNear && b.z() < kNear) continue;
    if (a.z() < kNear) begin = (kNear - a.z()) / (b.z() - a.z());
    if (b.z() < kNear) end = (kNear - a.z()) / (b.z() - a.z());
    for (int k = 0; k <= kSteps; ++k) {
      Vector3 p = a + (begin + (end - begin) * k / kSteps) * (b - a);
      p.z() = std::max(p.z(), kNear);
      take(p);
    }
  }
  if (low.x() > high.x()) return {0, 0, 0, 0};
  constexpr double kBorder = 4.0;  // px
  const auto whole = [](double x, int most) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(most)));
  };
  const int left = whole(std::floor(low.x() - kBorder), lens.width),
            top = whole(std::floor(low.y() - kBorder), lens.height);
  const int right = whole(std::ceil(high.x() + kBorder), lens.width),
            bottom = whole(std::ceil(high.y() + kBorder), lens.height);
  return {left, top, std::max(0, right - left), std::max(0, bottom - top)};
}

}  // namespace palpate::sim
