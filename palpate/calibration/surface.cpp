#include "palpate/calibration/surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/estimation/linear_algebra.h"

namespace palpate {
namespace {

constexpr double kTouchSdCounts = 8.0;  // residuals that a stated deviation of the touches is worth

Vector3 in_rectangle(int corner, double width, double height) {
  return {corner == 2 || corner == 3 ? width : 0.0, corner >= 3 ? height : 0.0, 0.0};
}

// Mean of the touches of each corner; refuses orders and shapes that no rectangle has.
Expected<std::array<Vector3, 4>> mean_corners(const std::vector<TouchedPoint>& points) {
  std::array<Vector3, 4> corners;
  for (int c = 1; c <= 4; ++c) {
    Vector3 sum = Vector3::Zero();
    double count = 0.0;
    for (const auto& point : points) {
      if (point.corner != c) continue;
      sum += point.place.m;
      count += 1.0;
    }
    if (count == 0.0)
      return refused("surface: corner {} was not touched; touch all four corners in order around the surface",
                     c);
    corners[static_cast<std::size_t>(c - 1)] = sum / count;
  }
  const double diagonal = std::max((corners[2] - corners[0]).norm(), (corners[3] - corners[1]).norm());
  const Vector3 normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
  for (std::size_t c = 0; c < 4; ++c) {
    const Vector3 in = corners[c] - corners[(c + 3) % 4], out = corners[(c + 1) % 4] - corners[c];
    if (in.norm() <= 0.01 * diagonal)
      return refused(
          "surface: corners {} and {} are the same place ({:.1f} mm apart); touch four different corners",
          (c + 3) % 4 + 1, c + 1, mm_from_metres(in.norm()));
    const double sine = in.cross(out).norm() / (in.norm() * out.norm());
    if (sine < 0.1)
      return refused("surface: corners {}, {} and {} lie on a line; touch the four corners of a rectangle",
                     (c + 3) % 4 + 1, c + 1, (c + 1) % 4 + 1);
  }
  for (std::size_t c = 0; c < 4; ++c) {
    const Vector3 in = corners[c] - corners[(c + 3) % 4], out = corners[(c + 1) % 4] - corners[c];
    if (in.cross(out).dot(normal) <= 0.0)
      return refused(
          "surface: the corners were touched crosswise (the outline crosses itself near corner {}); touch "
          "them in order around the surface",
          c + 1);
  }
  return corners;
}

}  // namespace

Point<World> RectangleFit::corner(int number) const {
  return X_world_rectangle * Point<Rectangle>{in_rectangle(number, width, height)};
}

Expected<Estimate<RectangleFit>> fit_rectangle(std::vector<TouchedPoint> points,
                                               const RectangleOptions& options) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].place.m.allFinite())
      return refused("surface: point {} is not finite; touch it again", i + 1);
    if (points[i].corner < 0 || points[i].corner > 4)
      return wrong_use("surface: point {} names corner {}; 1 to 4 are expected", i + 1, points[i].corner);
  }
  if (points.size() < 4)
    return refused("surface: {}; the four corners are needed", counted(points.size(), "point"));
  if (std::all_of(points.begin(), points.end(), [](const auto& p) { return p.corner == 0; }))
    for (int c = 0; c < 4; ++c) points[static_cast<std::size_t>(c)].corner = c + 1;
  const auto corners = mean_corners(points);
  if (!corners) return tl::unexpected(corners.error());
  const auto& q = *corners;

  Estimate<RectangleFit> estimate;
  RectangleFit& fit = estimate.value;
  const Vector3 x = (q[1] - q[0] + q[2] - q[3]).normalized();
  const Vector3 z = (q[2] - q[0]).cross(q[3] - q[1]).normalized();
  Matrix3 axes;
  axes.col(0) = (x - x.dot(z) * z).normalized();
  axes.col(2) = z;
  axes.col(1) = z.cross(axes.col(0));
  fit.X_world_rectangle = {Quaternion(axes).normalized(), q[0]};
  fit.width = 0.5 * ((q[1] - q[0]).norm() + (q[2] - q[3]).norm());
  fit.height = 0.5 * ((q[3] - q[0]).norm() + (q[2] - q[1]).norm());

  Eigen::Matrix<double, 8, 8> normal;
  double chi2 = 0.0;
  Eigen::Index rows = 0;
  for (int iteration = 0; iteration < 50; ++iteration) {
    normal.setZero();
    Eigen::Matrix<double, 8, 1> gradient = Eigen::Matrix<double, 8, 1>::Zero();
    estimate.residuals.clear();
    chi2 = 0.0;
    rows = 0;
    const Matrix3 R = fit.X_world_rectangle.matrix();
    for (const auto& point : points) {
      const Vector3 offset = point.place.m - fit.X_world_rectangle.translation;
      if (point.corner > 0) {
        const Vector3 inside = in_rectangle(point.corner, fit.width, fit.height);
        const Vector3 arm = R * inside;
        Eigen::Matrix<double, 3, 8> J;
        J << -hat(arm), Matrix3::Identity(), R.col(0) * (inside.x() > 0.0 ? 1.0 : 0.0),
            R.col(1) * (inside.y() > 0.0 ? 1.0 : 0.0);
        estimate.residuals.push_back(offset - arm);
        normal += J.transpose() * J;
        gradient += J.transpose() * estimate.residuals.back();
        rows += 3;
      } else {
        const double distance = R.col(2).dot(offset);
        Eigen::Matrix<double, 1, 8> J = Eigen::Matrix<double, 1, 8>::Zero();
        J.head<3>() = -R.col(2).cross(offset).transpose();  // distance falls as the plane rises
        J.segment<3>(3) = R.col(2).transpose();
        estimate.residuals.push_back(distance * R.col(2));
        normal += J.transpose() * J;
        gradient += J.transpose() * distance;
        rows += 1;
      }
      chi2 += estimate.residuals.back().squaredNorm();
    }
    const Eigen::Matrix<double, 8, 1> step = solve_symmetric(normal, gradient);
    estimate.iterations = iteration + 1;
    fit.X_world_rectangle.rotation = (so3_exp(step.head<3>()) * fit.X_world_rectangle.rotation).normalized();
    fit.X_world_rectangle.translation += step.segment<3>(3);
    fit.width += step[6];
    fit.height += step[7];
    if (step.norm() < 1e-13) break;
  }
  if (!(fit.width > 0.0 && fit.height > 0.0))  // corners touched again elsewhere pull a thin one inside out
    return refused("surface: no rectangle fits the touched points; touch the four corners again, in order");
  estimate.termination = Termination::converged;
  const double known = options.touch_sd > 0.0 ? kTouchSdCounts : 0.0;
  const double freedoms = std::max(1.0, static_cast<double>(rows - 8) + known);
  estimate.covariance =
      (chi2 + known * options.touch_sd * options.touch_sd) / freedoms * covariance_from_information(normal);

  constexpr double kLargest = 100.0;  // m
  if (!(std::hypot(fit.width, fit.height) <= kLargest))
    return refused(
        "surface: is {:.0f} x {:.0f} m, at most {:.0f} m is expected; check the unit in the header (_mm or "
        "_m)",
        fit.width, fit.height, kLargest);
  const double limit =
      std::max(options.least_tolerance, options.tolerance * std::hypot(fit.width, fit.height));
  const Vector3 out = fit.X_world_rectangle.matrix().col(2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3& r = estimate.residuals[i];
    if (r.norm() <= limit) continue;
    const bool off_plane = std::abs(out.dot(r)) > 0.7 * r.norm();
    return refused(
        "surface: point {} is {:.1f} mm {} the best rectangle ({:.0f} x {:.0f} mm), at most {:.1f} mm is "
        "accepted; touch it "
        "again",
        i + 1, mm_from_metres(r.norm()), off_plane ? "off the plane of" : "away from its corner of",
        mm_from_metres(fit.width), mm_from_metres(fit.height), mm_from_metres(limit));
  }
  return estimate;
}

}  // namespace palpate
