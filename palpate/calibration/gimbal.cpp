#include "palpate/calibration/gimbal.h"

#include <cmath>

#include "palpate/calibration/internal/arm_problem.h"
#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/text.h"
#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr Eigen::Index kGimbalUnknowns = 8;  // gains 3, offsets 2, marker 3
constexpr double kGimbalGainSize = 0.1, kGimbalOffsetSize = 1.0;
constexpr std::size_t kFewestGimbalSamples = 6;
constexpr int kGimbalRounds = 40, kGimbalHuberRounds = 5;

using GimbalRow = Eigen::Matrix<double, 3, kGimbalUnknowns>;

// One sample: the stylus before the gimbal, and what was read and seen.
struct SeenStylus {
  Quaternion forearm, marker;  // R_world_..., the former with the gimbal at zero
  Vector3 psi;
};

std::vector<SeenStylus> usable_for_gimbal(const std::vector<device::ArmObservation>& samples,
                                          const ArmSolution& arm) {
  std::vector<SeenStylus> list;
  for (const auto& s : samples) {
    if (!s.gimbal || !s.marker) continue;
    const Vector3 theta = joint_angles(arm, {s.joints, {}, {}});
    list.push_back({arm.X_world_base.rotation * device::phantom_stylus(theta, Vector3::Zero()),
                    s.marker->rotation, *s.gimbal});
  }
  return list;
}

Quaternion turn_about(double angle, const Vector3& axis) {
  return Quaternion(Eigen::AngleAxisd(angle, axis));
}

// Rotation error in the marker, and its derivatives by the unknowns.
Vector3 stylus_error(const SeenStylus& seen, const GimbalSolution& at, GimbalRow* J) {
  const Vector3 angles = at.correction.apply(seen.psi);
  const Quaternion first = turn_about(angles[0], Vector3::UnitY()),
                   second = turn_about(angles[1], Vector3::UnitX()),
                   third = turn_about(angles[2], Vector3::UnitZ());
  const Quaternion predicted = seen.forearm * first * second * third * at.R_tip_marker;
  const Vector3 e = so3_log(seen.marker.conjugate() * predicted);
  if (J != nullptr) {
    const Quaternion after3 = at.R_tip_marker.conjugate(), after2 = after3 * third.conjugate(),
                     after1 = after2 * second.conjugate();
    const std::array<Vector3, 3> axis{after1 * Vector3::UnitY(), after2 * Vector3::UnitX(),
                                      after3 * Vector3::UnitZ()};
    for (Eigen::Index i = 0; i < 3; ++i) {
      J->col(i) = seen.psi[i] * axis[static_cast<std::size_t>(i)];
      if (i < 2) J->col(3 + i) = axis[static_cast<std::size_t>(i)];
    }
    J->rightCols<3>().setIdentity();
    // log(exp(e) exp(d)) for a small d: the right Jacobian's inverse, which is the left one's of -e.
    *J = (so3_left_jacobian_inverse(-e) * *J).eval();
  }
  return e;
}

GimbalSolution moved_gimbal(const GimbalSolution& at, const Eigen::Matrix<double, kGimbalUnknowns, 1>& x) {
  GimbalSolution result = at;
  result.correction.gain += x.head<3>();
  result.correction.offset.head<2>() += x.segment<2>(3);
  result.R_tip_marker = (at.R_tip_marker * so3_exp(x.tail<3>())).normalized();
  return result;
}

using GimbalEquations = NormalEquations<kGimbalUnknowns>;

// The cost, in units of the noise, with the prior about gains of 1 and offsets of 0 where asked for.
double gimbal_cost(const std::vector<SeenStylus>& all, const std::vector<double>& weights,
                   const GimbalSolution& at, double scale, bool prior, GimbalEquations* equations) {
  GimbalRow J;
  double cost = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Vector3 e = stylus_error(all[i], at, equations ? &J : nullptr);
    const double w = weights[i] / (scale * scale);
    cost += w * e.squaredNorm();
    if (equations) equations->add(J, e, w);
  }
  for (Eigen::Index k = 0; k < 5 && prior; ++k) {
    const double size = k < 3 ? kGimbalGainSize : kGimbalOffsetSize;
    const double off = k < 3 ? at.correction.gain[k] - 1.0 : at.correction.offset[k - 3];
    cost += off * off / (size * size);
    if (!equations) continue;
    equations->JtJ(k, k) += 1.0 / (size * size);
    equations->Jtr[k] += off / (size * size);
  }
  return cost;
}

Eigen::MatrixXd gimbal_information(const std::vector<SeenStylus>& all, const std::vector<double>& weights,
                                   const GimbalSolution& at, double scale, bool prior) {
  GimbalEquations equations;
  gimbal_cost(all, weights, at, scale, prior, &equations);
  return equations.JtJ;
}

// The mean turn of the marker on the stylus that the readings as they are suggest.
Quaternion mean_mount(const std::vector<SeenStylus>& all) {
  Matrix3 sum = Matrix3::Zero();
  for (const auto& seen : all) {
    const Quaternion stylus = seen.forearm * turn_about(seen.psi[0], Vector3::UnitY()) *
                              turn_about(seen.psi[1], Vector3::UnitX()) *
                              turn_about(seen.psi[2], Vector3::UnitZ());
    sum += (stylus.conjugate() * seen.marker).toRotationMatrix();
  }
  return Quaternion(nearest_rotation(sum).rotation).normalized();
}

int solve_gimbal(const std::vector<SeenStylus>& all, const std::vector<double>& weights, double scale,
                 GimbalSolution& at) {
  const auto evaluate = [&](const GimbalSolution& x, GimbalEquations* equations) {
    return gimbal_cost(all, weights, x, scale, true, equations);
  };
  return minimise<kGimbalUnknowns>(at, evaluate, moved_gimbal).iterations;
}

// What the arm's own uncertainty adds: how the estimate answers to each axis of the arm's covariance.
Eigen::MatrixXd covariance_from_arm(const std::vector<device::ArmObservation>& samples,
                                    const Estimate<ArmSolution>& arm, const GimbalSolution& at,
                                    const std::vector<double>& weights, double sigma,
                                    const Eigen::MatrixXd& information) {
  if (arm.covariance.size() == 0) return Eigen::MatrixXd::Zero(kGimbalUnknowns, kGimbalUnknowns);
  const auto parameters = parameters_named(arm.value.model, arm.value.parameters);
  const auto axes = symmetric_eigen(arm.covariance);
  const auto all = usable_for_gimbal(samples, arm.value);
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(kGimbalUnknowns, axes.values.size());
  for (Eigen::Index k = 0; k < axes.values.size(); ++k) {
    const Eigen::VectorXd step = std::sqrt(std::max(0.0, axes.values[k])) * axes.vectors.col(k);
    const auto other = usable_for_gimbal(samples, moved(arm.value, parameters, step));
    GimbalRow J;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Vector3 e = stylus_error(all[i], at, &J);
      const Vector3 change = stylus_error(other[i], at, nullptr) - e;
      gradients.col(k) += weights[i] / (sigma * sigma) * J.transpose() * change;
    }
  }
  const Eigen::MatrixXd answers = solve_symmetric_columns(information, gradients);
  return answers * answers.transpose();
}

// The marker without a twist about the stylus; the last joint's zero takes it. Gives how the unknowns with
// that zero among them (gains 3, offsets 3, marker 3) follow from those of the solve.
Eigen::MatrixXd without_twist(GimbalSolution& at) {
  const Quaternion q = at.R_tip_marker;
  const double twist = 2.0 * std::atan2(q.z(), q.w());
  at.correction.offset[2] += std::remainder(twist, 2.0 * std::numbers::pi);
  at.R_tip_marker = (turn_about(-twist, Vector3::UnitZ()) * q).normalized();

  // q exp(x): the twist is 2 atan2(z, w), and half of q (0, x) is q's change.
  Eigen::RowVector3d by_marker;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Vector3 x = Vector3::Unit(i);
    const Quaternion change = q * Quaternion(0.0, x[0], x[1], x[2]);
    by_marker[i] = (q.w() * change.z() - q.z() * change.w()) / (q.w() * q.w() + q.z() * q.z());
  }
  Eigen::MatrixXd follows = Eigen::MatrixXd::Zero(kGimbalUnknowns + 1, kGimbalUnknowns);
  follows.topLeftCorner<5, 5>().setIdentity();
  follows.block<1, 3>(5, 5) = by_marker;
  follows.bottomRightCorner<3, 3>() =
      Matrix3::Identity() - (at.R_tip_marker.conjugate() * Vector3::UnitZ()) * by_marker;
  return follows;
}

}  // namespace

std::vector<Vector3> gimbal_errors(const std::vector<device::ArmObservation>& samples, const ArmSolution& arm,
                                   const GimbalSolution& gimbal) {
  std::vector<Vector3> errors;
  for (const auto& seen : usable_for_gimbal(samples, arm))
    errors.push_back(stylus_error(seen, gimbal, nullptr));
  return errors;
}

Expected<Estimate<GimbalSolution>> calibrate_gimbal(const std::vector<device::ArmObservation>& samples,
                                                    const Estimate<ArmSolution>& arm_estimate) {
  const ArmSolution& arm = arm_estimate.value;
  if (arm.model.kind != device::ArmModel::Kind::phantom)
    return wrong_use("gimbal: {} has none that is known here; only arms of the PHANToM kind have",
                     arm.model.name);
  const auto all = usable_for_gimbal(samples, arm);
  if (all.size() < kFewestGimbalSamples)
    return refused("gimbal: {} with gimbal angles and a marker pose; at least {} are needed",
                   counted(all.size(), "sample"), kFewestGimbalSamples);
  for (const auto& seen : all)
    if (!seen.psi.allFinite() || !seen.marker.coeffs().allFinite())
      return refused("gimbal: a reading is not finite; remove it");

  Estimate<GimbalSolution> estimate;
  GimbalSolution& at = estimate.value;
  at.R_tip_marker = mean_mount(all);
  std::vector<double> weights(all.size(), 1.0);
  std::vector<Vector3> errors(all.size());
  double scale = 0.1;  // rad; the residuals' own after the first round
  estimate.termination = Termination::iteration_limit;
  for (int round = 0; round < kGimbalRounds; ++round) {
    const GimbalSolution before = at;
    estimate.iterations += solve_gimbal(all, weights, scale, at);
    for (std::size_t i = 0; i < all.size(); ++i) errors[i] = stylus_error(all[i], at, nullptr);
    scale = noise::robust_scale(errors, kGimbalUnknowns);
    for (std::size_t i = 0; i < all.size(); ++i)
      weights[i] = round < kGimbalHuberRounds ? noise::huber_weight(errors[i].norm(), scale)
                                              : noise::tukey_weight(errors[i].norm(), scale);
    const double change = (at.correction.gain - before.correction.gain).norm() +
                          (at.correction.offset - before.correction.offset).norm() +
                          angle_between(at.R_tip_marker, before.R_tip_marker);
    if (round > kGimbalHuberRounds && change < 1e-3 * scale + 1e-12) {
      estimate.termination = Termination::converged;
      break;
    }
  }

  double inliers = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool inlier = weights[i] > 0.0;
    estimate.inlier.push_back(inlier);
    weights[i] = inlier ? 1.0 : 0.0;
    inliers += weights[i];
  }
  const double freedom = 3.0 * inliers - static_cast<double>(kGimbalUnknowns);
  if (!(freedom > 0.0) || inliers < static_cast<double>(kFewestGimbalSamples))
    return refused("gimbal: only {:.0f} of {} samples agree with one model; check units and joint order",
                   inliers, all.size());
  // Who belongs counts in full, as the covariance has it: Tukey's weights would cost 8 % of variance.
  estimate.iterations += solve_gimbal(all, weights, scale, at);
  for (std::size_t i = 0; i < all.size(); ++i) {
    errors[i] = stylus_error(all[i], at, nullptr);
    squares += weights[i] * errors[i].squaredNorm();
  }
  const double sigma = std::max(noise::kLeastScale, std::sqrt(squares / freedom));
  const Eigen::MatrixXd information = gimbal_information(all, weights, at, sigma, true);
  estimate.covariance = covariance_from_information(information) +
                        covariance_from_arm(samples, arm_estimate, at, weights, sigma, information);
  // What the data leave to the prior: less is known of it than was plausible before.
  for (Eigen::Index k = 0; k < 5; ++k) {
    const double size = k < 3 ? kGimbalGainSize : kGimbalOffsetSize;
    if (estimate.standard_deviation(k) > 0.7 * size)
      estimate.unobservable.push_back(k < 3 ? fmt::format("gimbal_gain_{}", k + 1)
                                            : fmt::format("gimbal_offset_{}", k - 2));
  }
  estimate.unobservable.push_back("gimbal_offset_3");
  const Eigen::VectorXd values = symmetric_eigenvalues(gimbal_information(all, weights, at, sigma, false));
  estimate.condition = std::sqrt(values[values.size() - 1] / std::max(values[0], 1e-300));
  const Eigen::MatrixXd follows = without_twist(at);
  estimate.covariance = (follows * estimate.covariance * follows.transpose()).eval();
  return estimate;
}

}  // namespace palpate::calibration
