#include "palpate/calibration/arm_problem.h"

#include <ceres/ceres.h>

#include <cmath>

#include "palpate/calibration/absolute_orientation.h"
#include "palpate/estimation/linear_algebra.h"

namespace palpate {
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

// The number a parameter stands for; not for the base's rotation.
double& number_of(ArmSolution& arm, const ArmParameter& parameter) {
  const auto i = parameter.index;
  switch (parameter.part) {
    case Part::gain:
      return arm.gain[i];
    case Part::offset:
      return arm.offset[i];
    case Part::length:
      return i == 0 ? arm.model.lengths.l1 : arm.model.lengths.l2;
    case Part::a:
      return arm.model.joints[as_size(i)].a;
    case Part::d:
      return arm.model.joints[as_size(i)].d;
    case Part::alpha:
      return arm.model.joints[as_size(i)].alpha;
    case Part::tool:
      return arm.model.tool[i];
    case Part::tip:
      return arm.tip_in_marker[i];
    default:
      return arm.X_world_base.translation[i];
  }
}

Vector3 rotation_part(const std::vector<ArmParameter>& parameters, const Eigen::VectorXd& x) {
  Vector3 w = Vector3::Zero();
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].part == Part::base_rotation) w[parameters[k].index] = x[static_cast<Eigen::Index>(k)];
  return w;
}

// Residuals of all samples, then of the prior.
class ArmCost : public ceres::CostFunction {
 public:
  ArmCost(const std::vector<WeighedSample>& samples, const ArmSolution& start,
          const std::vector<ArmParameter>& parameters, const ArmSolution& nominal, double prior_scale)
      : samples_(samples),
        start_(start),
        parameters_(parameters),
        nominal_(nominal),
        prior_scale_(prior_scale) {
    const auto P = static_cast<int>(parameters.size());
    set_num_residuals(3 * static_cast<int>(samples.size()) + (prior_scale > 0.0 ? P : 0));
    mutable_parameter_block_sizes()->push_back(P);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const auto P = static_cast<Eigen::Index>(parameters_.size());
    const Eigen::Map<const Eigen::VectorXd> x(blocks[0], P);
    ArmSolution at = moved(start_, parameters_, x);
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> J(jacobians ? jacobians[0] : nullptr, jacobians ? num_residuals() : 0, P);
    const bool derive = jacobians && jacobians[0];
    const Matrix3 turn = left_jacobian(rotation_part(parameters_, x));
    Eigen::Matrix3Xd row(3, P);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const auto at_row = 3 * static_cast<Eigen::Index>(i);
      const Matrix3 W = std::sqrt(samples_[i].weight) * samples_[i].whitening;
      r.segment<3>(at_row) =
          W * arm_residual(at, *samples_[i].observation, parameters_, derive ? &row : nullptr);
      if (!derive) continue;
      if (!parameters_.empty() && parameters_[0].part == Part::base_rotation)
        row.leftCols<3>() = (row.leftCols<3>() * turn).eval();
      J.middleRows<3>(at_row) = W * row;
    }
    if (prior_scale_ > 0.0) {
      const auto first = 3 * static_cast<Eigen::Index>(samples_.size());
      if (derive) J.bottomRows(P).setZero();
      ArmSolution nominal = nominal_;
      for (Eigen::Index k = 0; k < P; ++k) {
        const auto& parameter = parameters_[as_size(k)];
        const bool base = parameter.part == Part::base_rotation || parameter.part == Part::base_translation;
        const double stiffness = base ? 0.0 : prior_scale_ / parameter.size;
        r[first + k] = base ? 0.0 : stiffness * (number_of(at, parameter) - number_of(nominal, parameter));
        if (derive) J(first + k, k) = stiffness;
      }
    }
    return r.allFinite();
  }

 private:
  const std::vector<WeighedSample>& samples_;
  const ArmSolution& start_;
  const std::vector<ArmParameter>& parameters_;
  const ArmSolution& nominal_;
  double prior_scale_;
};

// The base that fits best, given everything else.
void place_base(const std::vector<WeighedSample>& samples, ArmSolution& at) {
  std::vector<Vector3> from, to;
  std::vector<double> weights;
  for (const auto& sample : samples) {
    from.push_back(arm_tip(at.model, at.gain.cwiseProduct(sample.observation->joints) + at.offset).m);
    to.push_back(measured_tip(at, *sample.observation).m);
    weights.push_back(sample.weight);
  }
  const auto fit = fit_rigid(from, to, weights);
  at.X_world_base = {Quaternion(fit.rotation).normalized(), fit.translation};
}

// Variable projection (Golub, Pereyra 1973; Kaufman's form): derivatives with the base's own reaction taken
// out.
class InsideCost : public ceres::CostFunction {
 public:
  InsideCost(const std::vector<WeighedSample>& samples, const ArmSolution& start,
             const std::vector<ArmParameter>& parameters)
      : samples_(samples),
        start_(start),
        parameters_(parameters),
        base_(list_parameters(start.model, ArmFreedom{})) {
    set_num_residuals(3 * static_cast<int>(samples.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(parameters.size()));
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const auto P = static_cast<Eigen::Index>(parameters_.size());
    ArmSolution at = moved(start_, parameters_, Eigen::Map<const Eigen::VectorXd>(blocks[0], P));
    place_base(samples_, at);
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    const bool derive = jacobians && jacobians[0];
    Eigen::MatrixXd J(num_residuals(), P), B(num_residuals(), 6);
    Eigen::Matrix3Xd row(3, P), base_row(3, 6);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const auto at_row = 3 * static_cast<Eigen::Index>(i);
      const double w = std::sqrt(samples_[i].weight);
      r.segment<3>(at_row) =
          w * arm_residual(at, *samples_[i].observation, parameters_, derive ? &row : nullptr);
      if (!derive) continue;
      arm_residual(at, *samples_[i].observation, base_, &base_row);
      J.middleRows<3>(at_row) = w * row;
      B.middleRows<3>(at_row) = w * base_row;
    }
    if (derive) {
      const Eigen::MatrixXd projected = J - B * least_squares_columns(B, J);
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[0], num_residuals(), P) = projected;
    }
    return r.allFinite();
  }

 private:
  const std::vector<WeighedSample>& samples_;
  const ArmSolution& start_;
  const std::vector<ArmParameter>& parameters_;
  const std::vector<ArmParameter> base_;
};

struct Outcome {
  Eigen::VectorXd x;
  int iterations = 0;
  bool converged = false;
};

Outcome run_solver(ceres::CostFunction* cost, Eigen::Index size, int most_iterations) {
  Outcome outcome{Eigen::VectorXd::Zero(size), 0, true};
  if (size == 0) {
    delete cost;
    return outcome;
  }
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, outcome.x.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = most_iterations;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-18;
  options.parameter_tolerance = 1e-13;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  outcome.iterations = static_cast<int>(summary.iterations.size());
  outcome.converged = summary.termination_type == ceres::CONVERGENCE;
  return outcome;
}

double weighted_cost(const std::vector<WeighedSample>& samples, const ArmSolution& at) {
  double sum = 0.0;
  for (const auto& sample : samples)
    sum +=
        sample.weight * (sample.whitening * arm_residual(at, *sample.observation, {}, nullptr)).squaredNorm();
  return sum;
}

}  // namespace

std::vector<ArmParameter> list_parameters(const ArmModel& model, const ArmFreedom& freedom) {
  std::vector<ArmParameter> list;
  const auto joints = model.joint_count();
  const auto per_joint = [&](Part part, const char* name, double size) {
    for (Eigen::Index j = 0; j < joints; ++j)
      if (part != Part::offset || j > 0 || freedom.first_offset)
        list.push_back({part, j, fmt::format("{}_{}", name, j + 1), size});
  };
  const auto per_axis = [&](Part part, const char* name, double size) {
    for (Eigen::Index i = 0; i < 3; ++i)
      list.push_back({part, i, fmt::format("{}_{}", name, "xyz"[i]), size});
  };
  const bool dh = model.kind == ArmModel::Kind::dh;
  if (freedom.base) {
    per_axis(Part::base_rotation, "base_rotation", 1.0);
    per_axis(Part::base_translation, "base_translation", 1.0);
  }
  if (freedom.gains) per_joint(Part::gain, "gain", 0.1);
  if (freedom.offsets) per_joint(Part::offset, "offset", 1.0);
  if (freedom.lengths && !dh) {
    list.push_back({Part::length, 0, "length_1", 0.02});
    list.push_back({Part::length, 1, "length_2", 0.02});
  }
  if (freedom.lengths && dh) {
    per_joint(Part::a, "a", 0.02);
    per_joint(Part::d, "d", 0.02);
  }
  if (freedom.alpha) per_joint(Part::alpha, "alpha", 0.175);
  if (freedom.tool) per_axis(Part::tool, "tool", 0.5);
  if (freedom.tip) per_axis(Part::tip, "tip", 0.1);
  return list;
}

ArmSolution moved(const ArmSolution& at, const std::vector<ArmParameter>& parameters,
                  const Eigen::VectorXd& x) {
  ArmSolution result = at;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].part != Part::base_rotation)
      number_of(result, parameters[k]) += x[static_cast<Eigen::Index>(k)];
  result.X_world_base.rotation =
      (so3_exp(rotation_part(parameters, x)) * at.X_world_base.rotation).normalized();
  return result;
}

Vector3 arm_residual(const ArmSolution& at, const ArmObservation& sample,
                     const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J) {
  const Eigen::VectorXd theta = at.gain.cwiseProduct(sample.joints) + at.offset;
  ArmJacobian D;
  const Vector3 tip = J ? arm_tip(at.model, theta, D).m : arm_tip(at.model, theta).m;
  const Matrix3 R = at.X_world_base.matrix();
  const Vector3 turned = R * tip;
  if (J) {
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
          column = R * D.theta.col(i) * sample.joints[i];
          break;
        case Part::offset:
          column = R * D.theta.col(i);
          break;
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
        case Part::tip:
          column = sample.marker ? Vector3(-sample.marker->matrix().col(i)) : Vector3(Vector3::Zero());
          break;
      }
    }
  }
  return turned + at.X_world_base.translation - measured_tip(at, sample).m;
}

ArmFit solve_arm(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                 const std::vector<ArmParameter>& parameters, const ArmSolution& nominal, double prior_scale,
                 int most_iterations) {
  const auto outcome = run_solver(new ArmCost(samples, start, parameters, nominal, prior_scale),
                                  static_cast<Eigen::Index>(parameters.size()), most_iterations);
  ArmFit fit{moved(start, parameters, outcome.x), 0.0, outcome.iterations, outcome.converged};
  fit.cost = weighted_cost(samples, fit.solution);
  return fit;
}

ArmFit solve_arm_inside(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                        const std::vector<ArmParameter>& parameters, int most_iterations) {
  const auto outcome = run_solver(new InsideCost(samples, start, parameters),
                                  static_cast<Eigen::Index>(parameters.size()), most_iterations);
  ArmFit fit{moved(start, parameters, outcome.x), 0.0, outcome.iterations, outcome.converged};
  place_base(samples, fit.solution);
  fit.cost = weighted_cost(samples, fit.solution);
  return fit;
}

Expected<ArmSolution> place_arm(const std::vector<WeighedSample>& samples, const ArmSolution& at,
                                bool fit_tip, bool fit_tool) {
  ArmSolution result = at;
  if (fit_tip) {
    // R_i t + p_i = M f_i + T is linear in t, T and the nine entries of M; then M's nearest rotation, and t,
    // T again.
    const auto n = static_cast<Eigen::Index>(samples.size());
    if (n < 6) return refused("arm: {} samples; at least 6 marker poses are needed to find the tip", n);
    Eigen::MatrixXd A(3 * n, 15), B(3 * n, 6);
    Eigen::VectorXd b(3 * n), c(3 * n);
    Vector3 mean = Vector3::Zero();
    std::vector<Vector3> f;
    for (const auto& sample : samples) {
      f.push_back(arm_tip(at.model, at.gain.cwiseProduct(sample.observation->joints) + at.offset).m);
      mean += f.back() / static_cast<double>(n);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      const Vector3 point = f[as_size(i)] - mean;
      const Matrix3 R = samples[as_size(i)].observation->marker->matrix();
      A.block<3, 3>(3 * i, 0) = R;
      A.block<3, 3>(3 * i, 3) = -Matrix3::Identity();
      for (Eigen::Index k = 0; k < 3; ++k) A.block<3, 3>(3 * i, 6 + 3 * k) = -point[k] * Matrix3::Identity();
      b.segment<3>(3 * i) = -samples[as_size(i)].observation->marker->translation;
    }
    const Eigen::VectorXd linear = least_squares(A, b);
    Matrix3 M;
    M << linear.segment<3>(6), linear.segment<3>(9), linear.segment<3>(12);
    const Matrix3 turn = nearest_rotation(M).rotation;
    B = A.leftCols<6>();
    for (Eigen::Index i = 0; i < n; ++i)
      c.segment<3>(3 * i) = b.segment<3>(3 * i) + turn * (f[as_size(i)] - mean);
    const double least = singular_values(B).values[5] / std::sqrt(static_cast<double>(n));
    if (!(least > 0.02))
      return refused(
          "arm: the stylus hardly turns over the samples ({:.3f} rad rms about the weakest axis, 0.02 are "
          "needed), "
          "so its tip cannot be found with the arm; turn it more, or give the tip of a pivot calibration",
          least);
    const Eigen::VectorXd tip_and_place = least_squares(B, c);
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

}  // namespace palpate
