#include "palpate/calibration/surface.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"
#include "palpate/math/pose_step.h"

namespace palpate::calibration {
namespace {

constexpr int kTouchRounds = 50;

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

using RectangleMatrix = Eigen::Matrix<double, 8, 8>;

// Of a corner's place by the eight unknowns.
Eigen::Matrix<double, 3, 8> corner_jacobian(int corner, const RectangleFit& fit) {
  const Matrix3 R = fit.X_world_rectangle.matrix();
  const Vector3 inside = in_rectangle(corner, fit.width, fit.height);
  Eigen::Matrix<double, 3, 8> J;
  J << -hat(R * inside), Matrix3::Identity(), R.col(0) * (inside.x() > 0.0 ? 1.0 : 0.0),
      R.col(1) * (inside.y() > 0.0 ? 1.0 : 0.0);
  return J;
}

// Of what a point misses the plane by, turned round: of the residual's part that the unknowns explain.
Eigen::Matrix<double, 1, 8> plane_jacobian(const Vector3& normal, const Vector3& offset) {
  Eigen::Matrix<double, 1, 8> J = Eigen::Matrix<double, 1, 8>::Zero();
  J.head<3>() = -normal.cross(offset).transpose();  // distance falls as the plane rises
  J.segment<3>(3) = normal.transpose();
  return J;
}

// How far the hand misses: W and `within` freedoms, of touches of one corner about their mean, are the hand
// alone; B and `between`, of corners and points about the rectangle, hold n times the tracker's variance
// besides. Their share of the hand, w = s^2 / (s^2 + n t), depends on the answer, so it is found by turns:
//   s^2 = (f0 s0^2 + W + w^2 B) / (f0 + within + w between)
void learn_hand(const std::vector<TouchedPoint>& points, const std::vector<Vector3>& residuals,
                Eigen::Index freedoms, const RectangleOptions& options, RectangleFit& fit) {
  std::array<Vector3, 4> sum;
  sum.fill(Vector3::Zero());
  std::array<double, 4> count{};
  double total = 0.0, tracker = 0.0, corners = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    total += residuals[i].squaredNorm();
    tracker += points[i].tracker.trace() / 3.0 / static_cast<double>(points.size());
    if (points[i].corner == 0) continue;
    const auto c = static_cast<std::size_t>(points[i].corner - 1);
    sum[c] += residuals[i];
    count[c] += 1.0, corners += 1.0;
  }
  double mean = 0.0;  // the part of the corners' squares that their means make up
  for (std::size_t c = 0; c < 4; ++c) mean += sum[c].squaredNorm() / count[c];
  double of_corners = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].corner > 0) of_corners += residuals[i].squaredNorm();
  const double W = of_corners - mean, B = total - W, within = 3.0 * (corners - 4.0),
               between = static_cast<double>(freedoms) - within;
  // Corners and points, weighed by their number, for the tracker's part in a between-residual.
  const double touches_each = (corners * corners / 4.0 + static_cast<double>(points.size()) - corners) /
                              static_cast<double>(points.size());
  const rig::TouchNoise& known = options.touch;
  fit.touch = known;
  if (!options.learn) return;
  double variance = known.sd * known.sd + (W + B) / std::max(1.0, static_cast<double>(freedoms));
  for (int round = 0; round < kTouchRounds; ++round) {
    const double share = variance > 0.0 ? variance / (variance + touches_each * tracker) : 0.0;
    fit.seen.freedoms = within + share * between;
    fit.seen.sd = fit.seen.freedoms > 0.0 ? std::sqrt((W + share * share * B) / fit.seen.freedoms) : 0.0;
    fit.touch = noise::pooled(known, fit.seen);
    variance = fit.touch.sd * fit.touch.sd;
  }
}

// J' T J over what shares the tracker's error: the touches of a corner together, every other point alone.
RectangleMatrix shared_by_corner(const std::vector<TouchedPoint>& points, const RectangleFit& fit) {
  RectangleMatrix shared = RectangleMatrix::Zero();
  std::array<Matrix3, 4> of_corner;
  of_corner.fill(Matrix3::Zero());
  std::array<double, 4> count{};
  const Vector3 normal = fit.X_world_rectangle.matrix().col(2);
  for (const auto& point : points) {
    if (point.corner > 0) {
      of_corner[static_cast<std::size_t>(point.corner - 1)] += point.tracker;
      count[static_cast<std::size_t>(point.corner - 1)] += 1.0;
    } else {
      const auto J = plane_jacobian(normal, point.place.m - fit.X_world_rectangle.translation);
      shared += J.transpose() * normal.dot(point.tracker * normal) * J;
    }
  }
  for (int corner = 1; corner <= 4; ++corner) {
    const auto c = static_cast<std::size_t>(corner - 1);
    const auto J = corner_jacobian(corner, fit);
    shared += J.transpose() * (count[c] * of_corner[c]) * J;  // n^2 times their mean
  }
  return shared;
}

}  // namespace

Point<World> RectangleFit::corner(int number) const {
  return X_world_rectangle * Point<Rectangle>{in_rectangle(number, width, height)};
}

namespace {

// Corners as they are counted: 1 to 4, or 0 for a point in the plane; where none is named, the first four.
Expected<void> check_and_count(std::vector<TouchedPoint>& points) {
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
  return {};
}

void set_start(const std::array<Vector3, 4>& q, RectangleFit& fit) {
  const Vector3 x = (q[1] - q[0] + q[2] - q[3]).normalized();
  const Vector3 z = (q[2] - q[0]).cross(q[3] - q[1]).normalized();
  Matrix3 axes;
  axes.col(0) = (x - x.dot(z) * z).normalized();
  axes.col(2) = z;
  axes.col(1) = z.cross(axes.col(0));
  fit.X_world_rectangle = {Quaternion(axes).normalized(), q[0]};
  fit.width = 0.5 * ((q[1] - q[0]).norm() + (q[2] - q[3]).norm());
  fit.height = 0.5 * ((q[3] - q[0]).norm() + (q[2] - q[1]).norm());
}

// What every point misses by, m, in World axes; the sum of their squares.
double rectangle_cost(const std::vector<TouchedPoint>& points, const RectangleFit& fit,
                      NormalEquations<8>* equations, std::vector<Vector3>* residuals) {
  const Matrix3 R = fit.X_world_rectangle.matrix();
  double cost = 0.0;
  for (const auto& point : points) {
    const Vector3 offset = point.place.m - fit.X_world_rectangle.translation;
    Vector3 r;
    if (point.corner > 0) {
      r = offset - R * in_rectangle(point.corner, fit.width, fit.height);
      if (equations) equations->add(-corner_jacobian(point.corner, fit), r);
    } else {
      const double distance = R.col(2).dot(offset);
      r = distance * R.col(2);
      if (equations) equations->add(-plane_jacobian(R.col(2), offset), Eigen::Matrix<double, 1, 1>(distance));
    }
    cost += r.squaredNorm();
    if (residuals) residuals->push_back(r);
  }
  return cost;
}

RectangleFit moved_rectangle(const RectangleFit& fit, const Eigen::Matrix<double, 8, 1>& step) {
  RectangleFit next = fit;
  next.X_world_rectangle = moved(fit.X_world_rectangle, step.head<6>());
  next.width += step[6];
  next.height += step[7];
  return next;
}

// The number of equations, and J^T J at the end.
Eigen::Index fit_by_least_squares(const std::vector<TouchedPoint>& points, Estimate<RectangleFit>& estimate,
                                  RectangleMatrix& normal) {
  const auto evaluate = [&](const RectangleFit& fit, NormalEquations<8>* equations) {
    return rectangle_cost(points, fit, equations, nullptr);
  };
  const auto solved = minimise<8>(estimate.value, evaluate, moved_rectangle);
  estimate.iterations = solved.iterations;
  NormalEquations<8> found;
  rectangle_cost(points, estimate.value, &found, &estimate.residuals);
  normal = found.JtJ;
  Eigen::Index rows = 0;
  for (const auto& point : points) rows += point.corner > 0 ? 3 : 1;
  return rows;
}

// Refused: a rectangle of another unit, a point away from it.
Expected<void> check_fit(const std::vector<TouchedPoint>& points, const RectangleOptions& options,
                         const Estimate<RectangleFit>& estimate) {
  const RectangleFit& fit = estimate.value;
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
        "accepted; touch it again",
        i + 1, mm_from_metres(r.norm()), off_plane ? "off the plane of" : "away from its corner of",
        mm_from_metres(fit.width), mm_from_metres(fit.height), mm_from_metres(limit));
  }
  return {};
}

}  // namespace

Expected<Estimate<RectangleFit>> fit_rectangle(std::vector<TouchedPoint> points,
                                               const RectangleOptions& options) {
  if (auto fine = check_and_count(points); !fine) return tl::unexpected(fine.error());
  const auto corners = mean_corners(points);
  if (!corners) return tl::unexpected(corners.error());
  Estimate<RectangleFit> estimate;
  RectangleFit& fit = estimate.value;
  set_start(*corners, fit);
  RectangleMatrix normal;
  const Eigen::Index rows = fit_by_least_squares(points, estimate, normal);
  if (!(fit.width > 0.0 && fit.height > 0.0))  // corners touched again elsewhere pull a thin one inside out
    return refused("surface: no rectangle fits the touched points; touch the four corners again, in order");
  estimate.termination = Termination::converged;
  learn_hand(points, estimate.residuals, rows - 8, options, fit);
  const RectangleMatrix inverse = covariance_from_information(normal);
  estimate.covariance =
      fit.touch.sd * fit.touch.sd * inverse + inverse * shared_by_corner(points, fit) * inverse;
  if (auto fine = check_fit(points, options, estimate); !fine) return tl::unexpected(fine.error());
  return estimate;
}

Expected<std::vector<Estimate<RectangleFit>>> fit_rectangles(const std::vector<SurfaceTouches>& touched,
                                                             const RectangleOptions& options) {
  std::vector<Estimate<RectangleFit>> fits;
  RectangleOptions known = options;
  for (const auto& surface : touched) {
    auto fit = fit_rectangle(surface.points, known);
    if (!fit && touched.size() > 1) fit.error().message = surface.name + ": " + fit.error().message;
    if (!fit) return tl::unexpected(fit.error());
    if (options.learn) known.touch = fit->value.touch;
    fits.push_back(std::move(*fit));
  }
  known.learn = false;
  for (std::size_t i = 0; i < touched.size() && options.learn; ++i) {
    auto fit = fit_rectangle(touched[i].points, known);
    if (!fit) return tl::unexpected(fit.error());
    fit->value.seen = fits[i].value.seen;
    fits[i] = std::move(*fit);
  }
  return fits;
}

}  // namespace palpate::calibration
