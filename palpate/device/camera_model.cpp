#include "palpate/device/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace palpate::device {
namespace {

constexpr double kOnAxis = 1e-8;

// Where an angle from the axis is seen, and how that grows with the angle.
double seen_at(const std::array<double, 5>& k, double angle, double& growth) {
  const double t2 = angle * angle;
  growth = 1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
  return angle * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

// The angle that is seen at this distance, by Newton's method from the axis outwards; empty where the polynomial turns back
// before.
std::optional<double> angle_seen_at(const std::array<double, 5>& k, double distance) {
  constexpr double kFarthest = 0.95 * std::numbers::pi;
  double angle = std::min(distance, kFarthest), growth = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double off = seen_at(k, angle, growth) - distance;
    if (!(growth > 1e-6)) return std::nullopt;
    if (std::abs(off) < 1e-14) break;
    angle = std::clamp(angle - off / growth, 0.0, kFarthest);
  }
  if (!(std::abs(seen_at(k, angle, growth) - distance) < 1e-10)) return std::nullopt;
  // Beyond a place where it turned back the same distance is met a second time.
  for (double before = 0.0; before < angle; before += 0.02) {
    seen_at(k, before, growth);
    if (!(growth > 0.0)) return std::nullopt;
  }
  return angle;
}

Eigen::Vector2d seen_by_fisheye(const std::array<double, 5>& k, const Eigen::Vector2d& n,
                                Eigen::Matrix2d* derivative) {
  const double r = n.norm();
  if (r < kOnAxis) {
    if (derivative != nullptr) derivative->setIdentity();
    return n;
  }
  double growth = 1.0;
  const double scale = seen_at(k, std::atan(r), growth) / r;
  if (derivative != nullptr)
    *derivative = scale * Eigen::Matrix2d::Identity() +
                  (growth / (1.0 + r * r) - scale) / (r * r) * (n * n.transpose());
  return scale * n;
}

// Distorted point and its 2x2 derivative with respect to the ideal point.
Eigen::Vector2d distorted(const CameraModel& camera, const Eigen::Vector2d& n, Eigen::Matrix2d* derivative) {
  const auto& d = camera.distortion;
  if (camera.kind == LensKind::fisheye) return seen_by_fisheye(d, n, derivative);
  const double k1 = d[0], k2 = d[1], p1 = d[2], p2 = d[3], k3 = d[4];
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (derivative != nullptr) {
    const double slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3));  // d radial / d(r2) * 2
    (*derivative) << radial + slope * x * x + 2 * p1 * y + 6 * p2 * x,
        slope * x * y + 2 * p1 * x + 2 * p2 * y, slope * x * y + 2 * p1 * x + 2 * p2 * y,
        radial + slope * y * y + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

}  // namespace

const char* lens_word(LensKind kind) { return kLensWords[static_cast<std::size_t>(kind)]; }

std::optional<LensKind> lens_kind(std::string_view word) {
  for (std::size_t i = 0; i < kLensWords.size(); ++i)
    if (word == kLensWords[i]) return static_cast<LensKind>(i);
  return std::nullopt;
}

const char* coefficient_names(LensKind kind) {
  return kind == LensKind::fisheye ? "k1 k2 k3 k4" : "k1 k2 p1 p2 k3";
}

std::optional<double> angle_from_axis(const CameraModel& camera, const Pixel& pixel) {
  const Eigen::Vector2d at((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  if (camera.kind == LensKind::fisheye) return angle_seen_at(camera.distortion, at.norm());
  const auto n = camera.undistort(at);
  return n ? std::optional(std::atan(n->norm())) : std::nullopt;
}

std::optional<Pixel> drawn_pixel(const CameraModel& camera, const Pose<World, CameraOptical>& X_world_camera,
                                 const Vector3& point) {
  const auto p = X_world_camera.inverse() * Point<World>{point};
  if (p.m.z() < kNearestSeen) return std::nullopt;
  return camera.project_undistorted(p.m);
}

Eigen::Vector2d CameraModel::distort(const Eigen::Vector2d& n) const { return distorted(*this, n, nullptr); }

std::optional<Eigen::Vector2d> CameraModel::undistort(const Eigen::Vector2d& target) const {
  if (kind == LensKind::fisheye) {
    const double distance = target.norm();
    if (distance < kOnAxis) return target;
    const auto angle = angle_seen_at(distortion, distance);
    if (!angle || *angle > kWidestAngle) return std::nullopt;
    return Eigen::Vector2d(std::tan(*angle) / distance * target);
  }
  Eigen::Vector2d n = target;
  for (int i = 0; i < 30; ++i) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d residual = distorted(*this, n, &J) - target;
    // J is symmetric. Where both its eigenvalues are negative the model has carried the point through the centre.
    if (residual.norm() < 1e-13)
      return J.determinant() > 0 && J.trace() > 0 ? std::optional(n) : std::nullopt;
    if (std::abs(J.determinant()) < 1e-9) return std::nullopt;
    n -= J.inverse() * residual;
    if (!(n.norm() < 10.0)) return std::nullopt;
  }
  return (distort(n) - target).norm() < 1e-10 ? std::optional(n) : std::nullopt;
}

Pixel CameraModel::project(const Vector3& p) const {
  const auto n = distort({p.x() / p.z(), p.y() / p.z()});
  return {fx * n.x() + cx, fy * n.y() + cy};
}

std::optional<Pixel> CameraModel::undistort_pixel(const Pixel& pixel) const {
  const auto n = undistort({(pixel.x() - cx) / fx, (pixel.y() - cy) / fy});
  if (!n) return std::nullopt;
  return Pixel{fx * n->x() + cx, fy * n->y() + cy};
}

Pixel project(const CameraModel& camera, const Vector3& p, Eigen::Matrix<double, 2, 3>& jacobian) {
  const double iz = 1.0 / p.z(), x = p.x() * iz, y = p.y() * iz;
  Eigen::Matrix2d lens;
  const auto n = distorted(camera, {x, y}, &lens);
  Eigen::Matrix<double, 2, 3> ideal;
  ideal << iz, 0, -x * iz, 0, iz, -y * iz;
  jacobian.noalias() = lens * ideal;
  jacobian.row(0) *= camera.fx;
  jacobian.row(1) *= camera.fy;
  return {camera.fx * n.x() + camera.cx, camera.fy * n.y() + camera.cy};
}

Eigen::Matrix<double, 2, kLensParameters> lens_jacobian(const CameraModel& camera, const Vector3& p) {
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const auto n = camera.distort({x, y});
  const Eigen::Vector2d f(camera.fx, camera.fy), radial(camera.fx * x * r2, camera.fy * y * r2);
  Eigen::Matrix<double, 2, kLensParameters> J;
  if (camera.kind == LensKind::fisheye) {
    J.setZero();
    J(0, 0) = n.x(), J(1, 1) = n.y(), J(0, 2) = J(1, 3) = 1.0;
    const double r = std::sqrt(r2), angle = std::atan(r);
    if (r < kOnAxis) return J;
    double power = angle;
    for (int k = 0; k < 4; ++k) {
      power *= angle * angle;
      J.col(4 + k) = Eigen::Vector2d(camera.fx * x, camera.fy * y) * (power / r);
    }
    return J;
  }
  J << n.x(), 0, 1, 0, radial.x(), radial.x() * r2, f.x() * 2 * x * y, f.x() * (r2 + 2 * x * x),
      radial.x() * r2 * r2, 0, n.y(), 0, 1, radial.y(), radial.y() * r2, f.y() * (r2 + 2 * y * y),
      f.y() * 2 * x * y, radial.y() * r2 * r2;
  return J;
}

CameraModel changed_lens(CameraModel camera, const LensParameters& by) {
  camera.fx += by[0], camera.fy += by[1], camera.cx += by[2], camera.cy += by[3];
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    camera.distortion[i] += by[4 + static_cast<Eigen::Index>(i)];
  return camera;
}

Eigen::Matrix<double, 2, 3> projection_jacobian(const CameraModel& camera, const Vector3& p) {
  Eigen::Matrix<double, 2, 3> J;
  const double z = p.z();
  J << camera.fx / z, 0, -camera.fx * p.x() / (z * z), 0, camera.fy / z, -camera.fy * p.y() / (z * z);
  return J;
}

}  // namespace palpate::device
