#include "palpate/calibration/pivot.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/calibration/internal/pivot_covariance.h"
#include "palpate/calibration/internal/pivot_motion.h"
#include "palpate/calibration/internal/pivot_problem.h"
#include "palpate/calibration/internal/pivot_sphere.h"
#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"
#include "palpate/math/pose.h"

namespace palpate::calibration {
namespace {

// Beyond these the poses show no resting tip at all; a tip that slips or drags by millimetres stays below.
constexpr double kMostResidual = 0.010;  // m, 3-D rms
constexpr double kFarthestTip = 10.0;    // m, from its marker

Expected<void> check_rotation(const PivotData& data, double range, const Matrix3& A,
                              const PivotCalibrationOptions& options) {
  if (range < options.needed_rotation)
    return refused(
        "pivot: the marker turns by {:.1f} deg only, at least {:.0f} deg are needed; swing it further while "
        "the tip rests",
        degrees_from_radians(range), degrees_from_radians(options.needed_rotation));
  const double least = symmetric_eigenvalues(A)[0];
  double total = 0.0;
  for (double w : data.weight) total += w;
  const double tilt = std::sqrt(std::max(0.0, least) / total);
  if (tilt < options.needed_tilt)
    return refused(
        "pivot: the marker turns about one axis only ({:.2f} deg rms about the weakest, {:.0f} deg are "
        "needed), so the tip's place along it cannot be known; swing it in two directions",
        degrees_from_radians(tilt), degrees_from_radians(options.needed_tilt));
  return {};
}

std::size_t least_poses(const PivotCalibrationOptions& options) { return options.given_tip ? 1 : 4; }

// What is left once outliers have gone must carry the answer by itself.
Expected<void> check_inliers(const PivotData& data, const PivotCalibrationOptions& options) {
  PivotData inliers;  // those without weight must not count as rotation
  inliers.segments = data.segments;
  std::vector<double> left(data.segments, 0.0);
  for (std::size_t i = 0; i < data.size(); ++i) {
    if (data.weight[i] == 0.0) continue;
    left[data.segment[i]] += data.weight[i];
    inliers.R.push_back(data.R[i]);
    inliers.p.push_back(data.p[i]);
    inliers.motion.push_back(data.motion[i]);
    inliers.segment.push_back(data.segment[i]);
    inliers.weight.push_back(data.weight[i]);
  }
  for (std::size_t s = 0; s < data.segments; ++s)
    if (left[s] == 0.0)
      return refused(
          "pivot: no pose of segment {} agrees with the other segments; check that the marker sits as "
          "before, or leave it out",
          s + 1);
  if (options.given_tip) return {};
  return check_rotation(inliers, largest_rotation(inliers), tip_system(inliers).A, options);
}

// The poses in use, and what goes with them.
struct PivotInput {
  PivotData data;
  std::vector<Vector3> arm_motion;  // as many as poses, or none
  std::vector<double> time_s;
};

Expected<PivotInput> input_of(const std::vector<PivotPose>& poses, const PivotCalibrationOptions& options) {
  PivotInput input;
  PivotData& data = input.data;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto& pose = poses[i];
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite())
      return refused("pivot: pose {} is not finite; remove it", i + 1);
    if (pose.segment < 0) continue;
    if (options.with_motion && !pose.motion)
      return wrong_use("pivot: pose {} has no joint readings for --with-arm", i + 1);
    data.R.push_back(pose.rotation.toRotationMatrix());
    data.p.push_back(pose.translation);
    data.motion.push_back(Vector3::Zero());
    data.segment.push_back(static_cast<std::size_t>(pose.segment));
    data.weight.push_back(1.0);
    data.segments = std::max(data.segments, data.segment.back() + 1);
    if (pose.motion) input.arm_motion.push_back(*pose.motion);
    if (pose.time_s) input.time_s.push_back(*pose.time_s);
  }
  if (input.arm_motion.size() != data.size()) input.arm_motion.clear();
  if (data.size() < least_poses(options))
    return refused("pivot: {}; at least {} are needed", counted(data.size(), "pose"), least_poses(options));
  std::vector<int> count(data.segments, 0);
  for (std::size_t s : data.segment) ++count[s];
  if (const auto empty = std::find(count.begin(), count.end(), 0); empty != count.end())
    return wrong_use("pivot: segment {} has no poses; number the segments without gaps",
                     empty - count.begin());
  return input;
}

// Centres and radius first, the tip from them; what the 2006 paper does.
Expected<std::vector<Vector3>> solve_by_spheres(const PivotData& data, Estimate<PivotSolution>& estimate) {
  const auto sphere = fit_spheres(data);
  if (!sphere) return tl::unexpected(sphere.error());
  const auto S = static_cast<Eigen::Index>(data.segments);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3, 3 * S + 1);  // d tip / d (centres, radius)
  const double n = static_cast<double>(data.size());
  double chi2 = 0.0;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const Vector3 d = sphere->centres[data.segment[i]] - data.p[i] + data.motion[i];
    estimate.value.tip += data.R[i].transpose() * d / n;
    K.middleCols<3>(3 * static_cast<Eigen::Index>(data.segment[i])) += data.R[i].transpose() / n;
    chi2 += std::pow(d.norm() - sphere->radius, 2);
  }
  const double variance = chi2 / std::max(1.0, n - 3.0 * static_cast<double>(S) - 1.0);
  const Eigen::MatrixXd C = variance * covariance_from_information(sphere->normal);
  estimate.covariance.topLeftCorner<3, 3>() = K * C * K.transpose() + variance / n * Matrix3::Identity();
  estimate.covariance.bottomRightCorner(3 * S, 3 * S) = C.topLeftCorner(3 * S, 3 * S);
  estimate.covariance.topRightCorner(3, 3 * S) = (K * C).leftCols(3 * S);
  estimate.covariance.bottomLeftCorner(3 * S, 3) = estimate.covariance.topRightCorner(3, 3 * S).transpose();
  estimate.residuals = residuals_of(data, estimate.value.tip, sphere->centres);
  return sphere->centres;
}

// Huber's weights first, Tukey's for the end, about the scale that the median tells: who belongs. Those count in full
// then and the others not at all; the last solve is the caller's.
template <typename Solve>
void reweight(PivotData& data, double parameters, const Solve& solve, std::vector<Vector3>& pivots,
              Estimate<PivotSolution>& estimate) {
  for (int round = 0; round < 100; ++round) {
    const double scale = noise::robust_scale(estimate.residuals, parameters);
    for (std::size_t i = 0; i < data.size(); ++i)
      data.weight[i] = round < 10 ? noise::huber_weight(estimate.residuals[i].norm(), scale)
                                  : noise::tukey_weight(estimate.residuals[i].norm(), scale);
    const Vector3 before = estimate.value.tip;
    estimate.value.tip = solve();
    pivots = pivots_of(data, estimate.value.tip);
    estimate.residuals = residuals_of(data, estimate.value.tip, pivots);
    estimate.iterations = round + 1;
    if (round > 10 && (estimate.value.tip - before).norm() < 1e-11) break;
  }
  for (double& w : data.weight) {
    estimate.inlier.push_back(w > 0.0);
    w = w > 0.0 ? 1.0 : 0.0;
  }
}

// Of tip and pivots, c_s = mean_R t + mean_p, from white residuals. Not known (nan) where poses and unknowns
// are as many.
Eigen::MatrixXd white_covariance(const PivotData& data, const std::vector<Vector3>& residuals,
                                 double parameters, const PivotCalibrationOptions& options) {
  double chi2 = 0.0, used = 0.0;
  std::vector<double> weight(data.segments, 0.0);
  for (std::size_t i = 0; i < data.size(); ++i) {
    chi2 += data.weight[i] * residuals[i].squaredNorm();
    used += data.weight[i];
    weight[data.segment[i]] += data.weight[i];
  }
  const double freedom = 3.0 * used - parameters;
  const double variance = freedom > 0.0 ? chi2 / freedom : std::numeric_limits<double>::quiet_NaN();
  const auto system = tip_system(data);
  Matrix3 of_tip = Matrix3::Zero();
  if (options.with_motion && !options.given_tip) {
    Matrix6 N = Matrix6::Zero();
    for (std::size_t i = 0; i < data.size(); ++i) {
      Eigen::Matrix<double, 3, 6> J;
      J << data.R[i] - system.mean_R[data.segment[i]], hat(data.motion[i]);
      N += data.weight[i] * J.transpose() * J;
    }
    of_tip = variance * pseudo_inverse_symmetric(N).topLeftCorner<3, 3>();
  } else if (!options.given_tip) {
    of_tip = variance * system.A.inverse();
  }
  const auto S = static_cast<Eigen::Index>(data.segments);
  Eigen::MatrixXd covariance(3 + 3 * S, 3 + 3 * S);
  covariance.topLeftCorner<3, 3>() = of_tip;
  for (Eigen::Index s = 0; s < S; ++s) {
    const Matrix3& M = system.mean_R[static_cast<std::size_t>(s)];
    for (Eigen::Index q = 0; q < S; ++q)
      covariance.block<3, 3>(3 + 3 * s, 3 + 3 * q) =
          M * of_tip * system.mean_R[static_cast<std::size_t>(q)].transpose();
    covariance.block<3, 3>(3 + 3 * s, 3 + 3 * s) +=
        variance / weight[static_cast<std::size_t>(s)] * Matrix3::Identity();
    covariance.block<3, 3>(3 + 3 * s, 0) = M * of_tip;
    covariance.block<3, 3>(0, 3 + 3 * s) = (M * of_tip).transpose();
  }
  return covariance;
}

// A tip that was seen to move, yet was taken as resting: where it would lie else, and that in the covariance.
void count_motion(const PivotData& data, const TipMotion& arm, Estimate<PivotSolution>& estimate) {
  PivotData moved = data;
  Quaternion turn;
  double delay = 0.0;
  PivotSolution& solution = estimate.value;
  solution.tip_shift = solve_with_motion(moved, arm, turn, delay) - solution.tip;
  const auto system = tip_system(data);
  const auto S = static_cast<Eigen::Index>(data.segments);
  Eigen::MatrixXd carried(3 + 3 * S, 3);  // the pivots go with the tip
  carried.topRows(3).setIdentity();
  for (Eigen::Index s = 0; s < S; ++s)
    carried.middleRows(3 + 3 * s, 3) = system.mean_R[static_cast<std::size_t>(s)];
  const Eigen::VectorXd off = carried * *solution.tip_shift;
  estimate.covariance += off * off.transpose();
}

// Poses that show no tip, however small their deviation by count.
Expected<void> check_tip(const PivotData& data, const Estimate<PivotSolution>& estimate) {
  double square = 0.0, used = 0.0;
  for (std::size_t i = 0; i < data.size(); ++i) {
    square += data.weight[i] * estimate.residuals[i].squaredNorm();
    used += data.weight[i];
  }
  const double rms = std::sqrt(square / used), distance = estimate.value.tip.norm();
  if (!(distance <= kFarthestTip))
    return refused(
        "pivot: the tip would lie {:.0f} m from its marker, at most {:.0f} m is expected; check the unit in "
        "the header (_mm or _m)",
        distance, kFarthestTip);
  if (!(rms <= kMostResidual))
    return refused(
        "pivot: the poses agree with no resting tip (residual {:.1f} mm rms, at most {:.0f} mm is expected); "
        "check the order of the columns, of the quaternion above all, and that one pivot only is in them",
        mm_from_metres(rms), mm_from_metres(kMostResidual));
  return {};
}

// Each segment by itself: the spread of their tips shows what residuals cannot.
void judge_segments(const PivotData& data, const std::vector<Vector3>& pivots,
                    const PivotCalibrationOptions& options, PivotErrors errors,
                    Estimate<PivotSolution>& estimate) {
  PivotSolution& solution = estimate.value;
  solution.segments.resize(data.segments);
  Vector3 mean_tip = Vector3::Zero();
  double own = 0.0;
  for (std::size_t s = 0; s < data.segments; ++s) {
    PivotSegment& segment = solution.segments[s];
    segment.pivot = pivots[s];
    PivotData alone;
    alone.segments = 1;
    std::vector<Vector3> common;
    for (std::size_t i = 0; i < data.size(); ++i) {
      if (data.segment[i] != s) continue;
      ++segment.poses;
      if (data.weight[i] == 0.0) continue;
      common.push_back(estimate.residuals[i]);
      alone.R.push_back(data.R[i]);
      alone.p.push_back(data.p[i]);
      alone.motion.push_back(data.motion[i]);
      alone.segment.push_back(0);
      alone.weight.push_back(1.0);
    }
    segment.rms = segment.own_rms = rms_per_component(common);
    if (options.given_tip || alone.size() < 4) continue;
    const auto system = tip_system(alone);
    if (!check_rotation(alone, largest_rotation(alone), system.A, options)) continue;
    segment.own_tip = solve_symmetric(system.A, system.b);
    const auto own_residuals = residuals_of(alone, *segment.own_tip, pivots_of(alone, *segment.own_tip));
    segment.own_rms = rms_per_component(own_residuals);
    if (errors.field && !solution.tip_shift) {
      errors.turn_free = false;
      segment.own_covariance = pivot_covariance(alone, own_residuals, errors).total.topLeftCorner<3, 3>();
    }
    mean_tip += *segment.own_tip;
    own += 1.0;
  }
  if (own < 3.0) return;
  mean_tip /= own;
  for (const auto& segment : solution.segments)
    if (segment.own_tip)
      solution.tip_scatter +=
          (*segment.own_tip - mean_tip) * (*segment.own_tip - mean_tip).transpose() / (own - 1.0);
  const double stated = estimate.covariance.topLeftCorner<3, 3>().trace();
  if (errors.field && stated * own < solution.tip_scatter.trace())
    estimate.covariance *= solution.tip_scatter.trace() / (own * stated);
}

}  // namespace

Expected<Estimate<PivotSolution>> calibrate_pivot(const std::vector<PivotPose>& poses,
                                                  const PivotCalibrationOptions& options) {
  auto input = input_of(poses, options);
  if (!input) return tl::unexpected(input.error());
  PivotData& data = input->data;
  Estimate<PivotSolution> estimate;
  PivotSolution& solution = estimate.value;
  solution.rotation_range = largest_rotation(data);
  if (!options.given_tip)
    if (const auto enough = check_rotation(data, solution.rotation_range, tip_system(data).A, options);
        !enough)
      return tl::unexpected(enough.error());

  TipMotion arm;
  if (!input->arm_motion.empty()) arm = tip_motion(data, input->arm_motion, input->time_s);
  const double parameters = 3.0 * static_cast<double>(data.segments) + (options.given_tip ? 0.0 : 3.0) +
                            (options.with_motion ? 3.0 : 0.0);
  const auto S = static_cast<Eigen::Index>(data.segments);
  estimate.covariance = Eigen::MatrixXd::Zero(3 + 3 * S, 3 + 3 * S);
  std::vector<Vector3> pivots;
  if (options.method == PivotMethod::sphere && !options.given_tip) {
    auto centres = solve_by_spheres(data, estimate);
    if (!centres) return tl::unexpected(centres.error());
    pivots = std::move(*centres);
    estimate.termination = Termination::converged;
  } else {
    const auto solve = [&] {
      if (options.given_tip) return *options.given_tip;
      if (options.with_motion) return solve_with_motion(data, arm, solution.R_world_arm, solution.delay);
      const auto system = tip_system(data);
      return Vector3(solve_symmetric(system.A, system.b));
    };
    solution.tip = solve();
    pivots = pivots_of(data, solution.tip);
    estimate.residuals = residuals_of(data, solution.tip, pivots);
    if (options.method == PivotMethod::robust) {
      reweight(data, parameters, solve, pivots, estimate);
      const auto inliers = std::count(estimate.inlier.begin(), estimate.inlier.end(), true);
      if (static_cast<std::size_t>(inliers) < least_poses(options))
        return refused("pivot: only {} of {} poses agree with one another; the tip did not rest", inliers,
                       data.size());
      if (const auto enough = check_inliers(data, options); !enough) return tl::unexpected(enough.error());
      // With Tukey's weights the tip would scatter by 8 % more (variance) than its covariance says.
      solution.tip = solve();
      pivots = pivots_of(data, solution.tip);
      estimate.residuals = residuals_of(data, solution.tip, pivots);
      estimate.termination = Termination::converged;
    }
    estimate.covariance = white_covariance(data, estimate.residuals, parameters, options);
  }
  if (const auto fine = check_tip(data, estimate); !fine) return tl::unexpected(fine.error());

  const Vector3 spread = symmetric_eigenvalues(tip_system(data).A);
  estimate.condition = std::sqrt(spread[2] / std::max(spread[0], 1e-300));
  solution.correlation = integrated_correlation(data, estimate.residuals);
  const bool shared = options.shared_errors && options.method != PivotMethod::sphere;
  PivotErrors errors{.tip_free = !options.given_tip,
                     .turn_free = options.with_motion,
                     .motion_strain = options.with_motion ? options.motion_strain : 0.0,
                     .seed = options.seed};
  noise::SmoothError field;
  if (shared) {
    const auto known = pivot_covariance(data, estimate.residuals, errors);
    estimate.covariance = known.total;
    solution.bootstrap_std = known.bootstrap_std;
    solution.bootstrap_block = known.block;
    solution.field_sd = known.field.field_sd.norm() / std::sqrt(3.0);
    field = known.field;
    errors.field = &field;
  } else {
    estimate.covariance *= solution.correlation;
  }
  solution.tip_motion = std::sqrt(3.0) * rms_per_component(arm.centred);
  if (shared && !options.with_motion && !options.given_tip && solution.tip_motion > 0.0)
    count_motion(data, arm, estimate);
  judge_segments(data, pivots, options, errors, estimate);
  return estimate;
}

}  // namespace palpate::calibration
