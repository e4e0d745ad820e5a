#include "palpate/device/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace palpate::device {
namespace {

constexpr double kOnAxis = 1e-8;

// Where an angle from the axis is seen, and how that grows with the angle.
double seen_at(const LensCoefficients& k, double angle, double& growth) {
  const double t2 = angle * angle;
  growth = 1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
  return angle * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

// The angle that is seen at this distance, by Newton's method from the axis outwards; empty where the polynomial turns back
// before.
std::optional<double> angle_seen_at(const LensCoefficients& k, double distance) {
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

Eigen::Vector2d seen_by_fisheye(const LensCoefficients& k, const Eigen::Vector2d& n,
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

// By what a lens stretches what it sees at the squared distance r2 from the axis: above / below. Brown's `below` is 1.
struct Radial {
  double above, below;              // the polynomials
  double above_slope, below_slope;  // by r2
  double value() const { return above / below; }
  double slope() const { return (above_slope - value() * below_slope) / below; }
};

Radial radial_of(const CameraModel& camera, double r2) {
  const LensCoefficients& d = camera.distortion;
  const auto polynomial = [r2](double a, double b, double c) { return 1.0 + r2 * (a + r2 * (b + r2 * c)); };
  const auto slope = [r2](double a, double b, double c) { return a + r2 * (2.0 * b + 3.0 * r2 * c); };
  Radial radial{polynomial(d[0], d[1], d[4]), 1.0, slope(d[0], d[1], d[4]), 0.0};
  if (camera.kind == LensKind::rational)
    radial.below = polynomial(d[5], d[6], d[7]), radial.below_slope = slope(d[5], d[6], d[7]);
  return radial;
}

// About how far from the axis (of x/z, y/z) what is seen at this distance is, the tangential terms left out: the nearest such place.
// Empty where what is seen turns back towards the axis before. Behind the quotient's pole the same pixels are met a second time.
std::optional<double> radius_seen_at(const CameraModel& camera, double distance) {
  constexpr double kStep = 0.02, kFarthest = 10.0;
  double before = 0.0;
  for (double r = kStep; r < kFarthest; r += kStep) {
    const Radial radial = radial_of(camera, r * r);
    if (!(radial.below > 0.0)) return r - kStep;
    const double seen = r * radial.value();
    if (seen >= distance) return r - kStep * (seen - distance) / (seen - before);
    if (!(radial.value() + 2.0 * r * r * radial.slope() > 0.0)) return std::nullopt;
    before = seen;
  }
  return std::nullopt;
}

// Distorted point and its 2x2 derivative with respect to the ideal point.
Eigen::Vector2d distorted(const CameraModel& camera, const Eigen::Vector2d& n, Eigen::Matrix2d* derivative) {
  const auto& d = camera.distortion;
  if (camera.kind == LensKind::fisheye) return seen_by_fisheye(d, n, derivative);
  const double p1 = d[2], p2 = d[3];
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const Radial radial = radial_of(camera, r2);
  const double factor = radial.value();
  if (derivative != nullptr) {
    const double slope = 2.0 * radial.slope();
    (*derivative) << factor + slope * x * x + 2 * p1 * y + 6 * p2 * x,
        slope * x * y + 2 * p1 * x + 2 * p2 * y, slope * x * y + 2 * p1 * x + 2 * p2 * y,
        factor + slope * y * y + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * factor + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * factor + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

}  // namespace

const char* lens_word(LensKind kind) { return kLensWords[static_cast<std::size_t>(kind)]; }

std::optional<LensKind> lens_kind(std::string_view word) {
  for (std::size_t i = 0; i < kLensWords.size(); ++i)
    if (word == kLensWords[i]) return static_cast<LensKind>(i);
  return std::nullopt;
}

const char* coefficient_names(LensKind kind) {
  return kind == LensKind::fisheye ? "k1 k2 k3 k4"
         : kind == LensKind::brown ? "k1 k2 p1 p2 k3"
                                   : "k1 k2 p1 p2 k3 k4 k5 k6";
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

namespace {

// Of a lens whose bend is Brown's, or a quotient of such polynomials; from `n` on.
std::optional<Eigen::Vector2d> undistorted(const CameraModel& camera, const Eigen::Vector2d& target,
                                           Eigen::Vector2d n) {
  for (int i = 0; i < 30; ++i) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d residual = distorted(camera, n, &J) - target;
    // J is symmetric. Where both its eigenvalues are negative the model has carried the point through the centre.
    if (residual.norm() < 1e-13)
      return J.determinant() > 0 && J.trace() > 0 ? std::optional(n) : std::nullopt;
    if (std::abs(J.determinant()) < 1e-9) return std::nullopt;
    n -= J.inverse() * residual;
    if (!(n.norm() < 10.0)) return std::nullopt;
  }
  return (camera.distort(n) - target).norm() < 1e-10 ? std::optional(n) : std::nullopt;
}

}  // namespace

std::optional<Eigen::Vector2d> CameraModel::undistort(const Eigen::Vector2d& target) const {
  if (kind == LensKind::fisheye) {
    const double distance = target.norm();
    if (distance < kOnAxis) return target;
    const auto angle = angle_seen_at(distortion, distance);
    if (!angle || *angle > kWidestAngle) return std::nullopt;
    return Eigen::Vector2d(std::tan(*angle) / distance * target);
  }
  if (kind == LensKind::brown) return undistorted(*this, target, target);
  const double distance = target.norm();
  const auto radius = radius_seen_at(*this, distance);
  if (!radius || distance < kOnAxis) return radius ? std::optional(target) : std::nullopt;
  return undistorted(*this, target, *radius / distance * target);
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
  const Eigen::Vector2d f(camera.fx, camera.fy), seen(camera.fx * x, camera.fy * y);
  Eigen::Matrix<double, 2, kLensParameters> J = Eigen::Matrix<double, 2, kLensParameters>::Zero();
  J(0, 0) = n.x(), J(1, 1) = n.y(), J(0, 2) = J(1, 3) = 1.0;
  if (camera.kind == LensKind::fisheye) {
    const double r = std::sqrt(r2), angle = std::atan(r);
    if (r < kOnAxis) return J;
    double power = angle;
    for (int k = 0; k < 4; ++k) {
      power *= angle * angle;
      J.col(4 + k) = seen * (power / r);
    }
    return J;
  }
  const Radial radial = radial_of(camera, r2);
  const Eigen::Vector2d above = seen / radial.below, below = -radial.value() * above;
  J.col(4) = r2 * above, J.col(5) = r2 * r2 * above, J.col(8) = r2 * r2 * r2 * above;
  J.col(6) = f.cwiseProduct(Eigen::Vector2d(2 * x * y, r2 + 2 * y * y));
  J.col(7) = f.cwiseProduct(Eigen::Vector2d(r2 + 2 * x * x, 2 * x * y));
  if (camera.kind == LensKind::rational)
    J.col(9) = r2 * below, J.col(10) = r2 * r2 * below, J.col(11) = r2 * r2 * r2 * below;
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
