#include "palpate/calibration/internal/arm_problem.h"

#include <cmath>

#include "palpate/calibration/absolute_orientation.h"
#include "palpate/core/text.h"
#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

using Part = ArmParameter::Part;

std::size_t as_size(Eigen::Index i) { return static_cast<std::size_t>(i); }

// Derivative of exp(w) on the left: exp(w + dw) = exp(J dw) exp(w). Sola et al. (2018), equation 145.
Matrix3 left_jacobian(const Vector3& w) {
  const double angle = w.norm();
  const Matrix3 W = hat(w);
  if (angle < 1e-5) return Matrix3::Identity() + 0.5 * W + W * W / 6.0;
  const double a2 = angle * angle;
  return Matrix3::Identity() + (1.0 - std::cos(angle)) / a2 * W +
         (angle - std::sin(angle)) / (a2 * angle) * W * W;
}

// What a linearisation works with, kept between samples: allocating it anew costs as much as the arithmetic.
struct Scratch {
  Eigen::VectorXd theta;
  device::ArmJacobian D;
  Eigen::Matrix3Xd turning;  // R D.theta
};

void angles_into(const ArmSolution& arm, const ArmMotion& motion, Eigen::VectorXd& theta) {
  theta = arm.gain.cwiseProduct(motion.joints) + arm.offset;
  if (arm.quadratic.size() > 0) theta += arm.quadratic.cwiseProduct(motion.joints.cwiseAbs2());
  if (arm.hysteresis.size() > 0 && motion.direction.size() > 0)
    theta += arm.hysteresis.cwiseProduct(motion.direction);
}

// The tip in World without the base's translation; `J` without the marker's part.
Vector3 turned_tip(const ArmSolution& at, const ArmMotion& motion,
                   const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J, Scratch& scratch) {
  angles_into(at, motion, scratch.theta);
  const Matrix3 R = at.X_world_base.matrix();
  if (!J) return R * device::arm_tip(at.model, scratch.theta).m;
  const device::ArmJacobian& D = scratch.D;
  const Vector3 turned = R * device::arm_tip(at.model, scratch.theta, scratch.D).m;
  const Eigen::VectorXd& psi = motion.joints;
  scratch.turning = R.lazyProduct(D.theta);
  const Eigen::Matrix3Xd& turning = scratch.turning;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto i = parameters[k].index;
    auto column = J->col(static_cast<Eigen::Index>(k));
    switch (parameters[k].part) {
      case Part::base_rotation:
        column = Vector3::Unit(i).cross(turned);
        break;
      case Part::base_translation:
        column = Vector3::Unit(i);
        break;
      case Part::gain:
        column = turning.col(i) * psi[i];
        break;
      case Part::offset:
        column = turning.col(i);
        break;
      case Part::quadratic:
        column = turning.col(i) * (psi[i] * psi[i]);
        break;
      case Part::hysteresis:
        column = turning.col(i) * (motion.direction.size() > 0 ? motion.direction[i] : 0.0);
        break;
      case Part::delay: {
        column.setZero();
        for (Eigen::Index j = 0; j < motion.rate.size(); ++j) {
          const double slope = at.gain[j] + (at.quadratic.size() > 0 ? 2.0 * at.quadratic[j] * psi[j] : 0.0);
          column -= turning.col(j) * (slope * motion.rate[j]);
        }
        break;
      }
      case Part::length:
        column = R * D.lengths.col(i);
        break;
      case Part::a:
        column = R * D.a.col(i);
        break;
      case Part::d:
        column = R * D.d.col(i);
        break;
      case Part::alpha:
        column = R * D.alpha.col(i);
        break;
      case Part::tool:
        column = R * D.tool.col(i);
        break;
      case Part::correction:
        column = R * D.correction.col(i);
        break;
      case Part::tip:
        column.setZero();
        break;
    }
  }
  return turned;
}

Vector3 residual_with(const ArmSolution& at, const device::ArmObservation& sample, const ArmMotion& motion,
                      const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J, Scratch& scratch) {
  const Vector3 turned = turned_tip(at, motion, parameters, J, scratch);
  const Vector3 predicted = turned + at.X_world_base.translation;
  if (!by_marker(at, sample)) return predicted - sample.tip->m;
  const Matrix3 R = sample.marker->matrix();
  if (J)
    for (std::size_t k = 0; k < parameters.size(); ++k)
      if (parameters[k].part == Part::tip) J->col(static_cast<Eigen::Index>(k)) = -R.col(parameters[k].index);
  return predicted - R * at.tip_in_marker - sample.marker->translation;
}

// All residuals below each other; with their derivatives where asked for.
struct Stack {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
};

enum class Rows { whitened, whitened_and_weighed };

void stack_residuals(const std::vector<WeighedSample>& samples, const ArmSolution& at,
                     const ArmSolution& moved_from, const std::vector<ArmParameter>& parameters, bool derive,
                     Stack& stack, Scratch& scratch, Rows rows = Rows::whitened_and_weighed) {
  const auto P = static_cast<Eigen::Index>(parameters.size());
  stack.r.resize(3 * static_cast<Eigen::Index>(samples.size()));
  if (derive) stack.J.resize(stack.r.size(), P);
  Eigen::Matrix3Xd row(3, P);
  const double delay_moved = at.delay_s - moved_from.delay_s;
  ArmMotion shifted;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const WeighedSample& sample = samples[i];
    const auto at_row = 3 * static_cast<Eigen::Index>(i);
    const ArmMotion* motion = &sample.motion;
    if (delay_moved != 0.0 && sample.motion.rate.size() > 0) {
      shifted = sample.motion;
      shifted.joints -= delay_moved * sample.motion.rate;
      motion = &shifted;
    }
    const Matrix3 W = (rows == Rows::whitened ? 1.0 : std::sqrt(sample.weight)) * sample.whitening;
    stack.r.segment<3>(at_row) =
        W * residual_with(at, *sample.observation, *motion, parameters, derive ? &row : nullptr, scratch);
    if (derive) stack.J.middleRows<3>(at_row) = W.lazyProduct(row);  // too small for the blocked product
  }
}

double weighted_cost(const std::vector<WeighedSample>& samples, const ArmSolution& at) {
  Stack stack;
  Scratch scratch;
  stack_residuals(samples, at, at, {}, false, stack, scratch);
  return stack.r.squaredNorm();
}

using ArmEquations = NormalEquations<Eigen::Dynamic>;

void square(const Eigen::MatrixXd& J, const Eigen::VectorXd& r, ArmEquations& at) {
  at.JtJ.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
  at.Jtr.noalias() += J.transpose() * r;
}

// The base that fits best, given everything else.
void place_base(const std::vector<WeighedSample>& samples, ArmSolution& at) {
  std::vector<Vector3> from, to;
  std::vector<double> weights;
  for (const auto& sample : samples) {
    from.push_back(device::arm_tip(at.model, joint_angles(at, sample.motion)).m);
    to.push_back(measured_tip(at, *sample.observation).m);
    weights.push_back(sample.weight);
  }
  const auto fit = fit_rigid(from, to, weights);
  at.X_world_base = {Quaternion(fit.rotation).normalized(), fit.translation};
}

}  // namespace

Eigen::VectorXd joint_angles(const ArmSolution& arm, const ArmMotion& motion) {
  Eigen::VectorXd theta;
  angles_into(arm, motion, theta);
  return theta;
}

Vector3 arm_residual(const ArmSolution& at, const device::ArmObservation& sample, const ArmMotion& motion,
                     const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J) {
  Scratch scratch;
  return residual_with(at, sample, motion, parameters, J, scratch);
}

Vector3 arm_residual(const ArmSolution& at, const device::ArmObservation& sample,
                     const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J) {
  const auto rest = Eigen::VectorXd::Zero(sample.joints.size());
  return arm_residual(at, sample, {sample.joints, rest, rest}, parameters, J);
}

Eigen::VectorXd whitened_residuals(const std::vector<WeighedSample>& samples, const ArmSolution& at,
                                   const std::vector<ArmParameter>& parameters, Eigen::MatrixXd* J) {
  Stack stack;
  Scratch scratch;
  stack_residuals(samples, at, at, parameters, J != nullptr, stack, scratch, Rows::whitened);
  if (J) *J = std::move(stack.J);
  return std::move(stack.r);
}

void predicted_tip_derivatives(const ArmSolution& at, const ArmMotion& motion,
                               const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd& J) {
  Scratch scratch;
  J.resize(3, static_cast<Eigen::Index>(parameters.size()));
  turned_tip(at, motion, parameters, &J, scratch);
}

ArmFit solve_arm(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                 const std::vector<ArmParameter>& parameters, const ArmSolution& nominal, double prior_scale,
                 int most_iterations, double tolerance) {
  if (parameters.empty()) return {start, weighted_cost(samples, start), 0, true};
  const auto P = static_cast<Eigen::Index>(parameters.size());
  Stack stack;
  Scratch scratch;
  // Adds the prior to the cost; to the equations too where they are given.
  const auto prior = [&](const ArmSolution& at, ArmEquations* equations) {
    double cost = 0.0;
    for (Eigen::Index k = 0; k < P && prior_scale > 0.0; ++k) {
      const auto& parameter = parameters[as_size(k)];
      if (parameter.of_base()) continue;
      const double stiffness = prior_scale / parameter.size;
      const double r = stiffness * (number_of(at, parameter) - number_of(nominal, parameter));
      cost += r * r;
      if (!equations) continue;
      equations->JtJ(k, k) += stiffness * stiffness;
      equations->Jtr[k] += stiffness * r;
    }
    return cost;
  };
  const auto evaluate = [&](const Eigen::VectorXd& x, ArmEquations* equations) {
    const ArmSolution at = moved(start, parameters, x);
    stack_residuals(samples, at, start, parameters, equations != nullptr, stack, scratch);
    if (equations) {
      if (!parameters.empty() && parameters[0].part == Part::base_rotation)
        stack.J.leftCols<3>() = (stack.J.leftCols<3>() * left_jacobian(rotation_part(parameters, x))).eval();
      square(stack.J, stack.r, *equations);
    }
    return stack.r.squaredNorm() + prior(at, equations);
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(P);
  const auto solved = minimise(x, evaluate, {.most_iterations = most_iterations, .tolerance = tolerance});
  ArmFit fit{moved(start, parameters, x), 0.0, solved.iterations, solved.converged};
  fit.cost = solved.cost - prior(fit.solution, nullptr);
  return fit;
}

// Variable projection (Golub, Pereyra 1973; Kaufman's form): derivatives with the base's own reaction taken
// out.
ArmFit solve_arm_inside(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                        const std::vector<ArmParameter>& parameters, int most_iterations) {
  const auto P = static_cast<Eigen::Index>(parameters.size());
  const auto base = list_parameters(start.model, ArmFreedom{});
  Stack stack, base_stack;
  Scratch scratch;
  const auto placed = [&](const Eigen::VectorXd& x) {
    ArmSolution at = moved(start, parameters, x);
    place_base(samples, at);
    return at;
  };
  const auto evaluate = [&](const Eigen::VectorXd& x, ArmEquations* equations) {
    const ArmSolution at = placed(x);
    stack_residuals(samples, at, start, parameters, equations != nullptr, stack, scratch);
    if (equations) {
      stack_residuals(samples, at, start, base, true, base_stack, scratch);
      const Eigen::MatrixXd reaction = solve_symmetric_columns(base_stack.J.transpose() * base_stack.J,
                                                               base_stack.J.transpose() * stack.J);
      square(stack.J - base_stack.J * reaction, stack.r, *equations);
    }
    return stack.r.squaredNorm();
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(P);
  const auto solved = minimise(x, evaluate, {.most_iterations = most_iterations});
  ArmFit fit{placed(x), 0.0, solved.iterations, solved.converged};
  fit.cost = weighted_cost(samples, fit.solution);
  return fit;
}

Expected<ArmSolution> place_arm(const std::vector<WeighedSample>& samples, const ArmSolution& at,
                                bool fit_tip, bool fit_tool) {
  ArmSolution result = at;
  if (fit_tip) {
    // R_i t + p_i = M f_i + T is linear in t, T and the nine entries of M; then M's nearest rotation, and t,
    // T again. Both by their normal equations, whose blocks are sums of R_i and f_i.
    if (samples.size() < 6)
      return refused("arm: {}; at least 6 marker poses are needed to find the tip",
                     counted(samples.size(), "sample"));
    const double n = static_cast<double>(samples.size());
    Vector3 mean = Vector3::Zero();
    std::vector<Vector3> f;
    for (const auto& sample : samples) {
      f.push_back(device::arm_tip(at.model, joint_angles(at, sample.motion)).m);
      mean += f.back() / n;
    }
    Eigen::Matrix<double, 15, 15> N = Eigen::Matrix<double, 15, 15>::Zero();  // t, T, columns of M
    Eigen::Matrix<double, 15, 1> b = Eigen::Matrix<double, 15, 1>::Zero();
    const auto I = Matrix3::Identity();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto& marker = *samples[i].observation->marker;
      const Matrix3 Rt = marker.matrix().transpose();
      const Vector3& p = marker.translation;
      const Vector3 point = f[i] - mean;
      N.block<3, 3>(0, 0) += I;
      N.block<3, 3>(0, 3) -= Rt;
      N.block<3, 3>(3, 3) += I;
      b.segment<3>(0) -= Rt * p;
      b.segment<3>(3) += p;
      for (Eigen::Index k = 0; k < 3; ++k) {
        N.block<3, 3>(0, 6 + 3 * k) -= point[k] * Rt;
        b.segment<3>(6 + 3 * k) += point[k] * p;
        for (Eigen::Index l = k; l < 3; ++l)
          N.block<3, 3>(6 + 3 * k, 6 + 3 * l).diagonal().array() += point[k] * point[l];
      }
    }
    N.triangularView<Eigen::StrictlyLower>() = N.transpose();
    const Matrix6 of_tip_and_place = N.topLeftCorner<6, 6>();
    const Vector6 of_markers = b.head<6>();
    // Points in a plane tell nothing of M's third column; the nearest rotation completes it.
    N.diagonal().array() += 1e-10 * N.trace();
    const Eigen::VectorXd linear = solve_symmetric(N, b);
    Matrix3 M;
    M << linear.segment<3>(6), linear.segment<3>(9), linear.segment<3>(12);
    const Matrix3 turn = nearest_rotation(M).rotation;
    Vector6 c = of_markers;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Vector3 point = turn * (f[i] - mean);
      c.head<3>() += samples[i].observation->marker->rotation.conjugate() * point;
      c.tail<3>() -= point;
    }
    const double least = std::sqrt(std::max(0.0, symmetric_eigenvalues(of_tip_and_place)[0]) / n);
    if (!(least > 0.02))
      return refused(
          "arm: the stylus hardly turns over the samples ({:.3f} rad rms about the weakest axis, 0.02 are "
          "needed), so its tip cannot be found with the arm; turn it more, or give the tip of a pivot "
          "calibration",
          least);
    const Eigen::VectorXd tip_and_place = solve_symmetric(of_tip_and_place, c);
    result.tip_in_marker = tip_and_place.head<3>();
    result.tip_known = true;
    result.X_world_base = {Quaternion(turn).normalized(), tip_and_place.tail<3>() - turn * mean};
  }
  place_base(samples, result);
  if (fit_tool) {
    ArmSolution nominal = result;
    ArmFreedom freedom;
    freedom.tool = true;
    result = solve_arm(samples, result, list_parameters(at.model, freedom), nominal, 1e-3).solution;
  }
  return result;
}

}  // namespace palpate::calibration
