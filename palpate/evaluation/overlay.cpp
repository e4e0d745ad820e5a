#include "palpate/evaluation/overlay.h"

namespace palpate::evaluation {

std::optional<device::Pixel> drawn_pixel(const CameraView& estimated, const Vector3& point) {
  return device::drawn_pixel(estimated.lens, estimated.X_world_camera, point);
}

std::optional<device::Pixel> real_pixel(const CameraView& truth, const device::CameraModel& estimated_lens,
                                        const Vector3& point) {
  const auto p = truth.X_world_camera.inverse() * Point<World>{point};
  if (p.m.z() < device::kNearestSeen) return std::nullopt;
  // Far outside the field of view the lens polynomial folds back into the image: ask the ideal ray first.
  const device::Pixel ideal = truth.lens.project_undistorted(p.m);
  const double w = truth.lens.width, h = truth.lens.height;
  if (ideal.x() < -0.5 * w || ideal.x() > 1.5 * w || ideal.y() < -0.5 * h || ideal.y() > 1.5 * h)
    return std::nullopt;
  const device::Pixel seen = truth.lens.project(p.m);
  if (seen.x() < 0 || seen.x() > w - 1 || seen.y() < 0 || seen.y() > h - 1) return std::nullopt;
  return estimated_lens.undistort_pixel(seen);
}

std::optional<double> overlay_error(const CameraView& estimated, const Vector3& estimated_point,
                                    const CameraView& truth, const Vector3& true_point) {
  const auto real = real_pixel(truth, estimated.lens, true_point);
  const auto drawn = drawn_pixel(estimated, estimated_point);
  if (!real || !drawn) return std::nullopt;
  return (*drawn - *real).norm();
}

}  // namespace palpate::evaluation
