#include "palpate/calibration/internal/force_fit.h"

#include <array>
#include <cmath>

#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr Eigen::Index kShape = 5, kSymmetric = 6;

// A basis of the symmetric matrices of Frobenius norm 1; the last is the trace.
const std::array<Matrix3, 6>& symmetric_basis() {
  static const std::array<Matrix3, 6> basis = [] {
    std::array<Matrix3, 6> b;
    b.fill(Matrix3::Zero());
    b[0].diagonal() = Vector3(1.0, -1.0, 0.0) / std::sqrt(2.0);
    b[1].diagonal() = Vector3(1.0, 1.0, -2.0) / std::sqrt(6.0);
    const double off = 1.0 / std::sqrt(2.0);
    b[2](0, 1) = b[2](1, 0) = b[3](0, 2) = b[3](2, 0) = b[4](1, 2) = b[4](2, 1) = off;
    b[5].diagonal().setConstant(1.0 / std::sqrt(3.0));
    return b;
  }();
  return basis;
}

// Scaled and squared (Moler, Van Loan 2003): no decomposition, as it is taken thousands of times.
Matrix3 exponential(const Matrix3& symmetric) {
  constexpr double kMost = 20.0;  // of its size: a step of the search may go astray
  const double size = symmetric.norm();
  Matrix3 X = size > kMost ? Matrix3(symmetric * (kMost / size)) : symmetric;
  constexpr int kSquarings = 6, kOrder = 8;
  X /= 1 << kSquarings;
  Matrix3 sum = Matrix3::Identity();
  for (int i = kOrder; i > 0; --i) sum = (Matrix3::Identity() + X * sum / i).eval();
  for (int i = 0; i < kSquarings; ++i) sum = (sum * sum).eval();
  return sum;
}

// The unknowns: gains, shape of the hand (5), then its change in each pose (6).
class ForceModel {
 public:
  ForceModel(std::span<const PoseCompliance> poses, const ForceExplanation& explanation,
             const ForceCheckSettings& settings)
      : poses_(poses),
        settings_(settings),
        gains_(static_cast<Eigen::Index>(explanation.order.size())),
        scale_(scale_of(poses)) {
    for (const auto& pose : poses)
      for (Eigen::Index i = 0; i < gains_; ++i)
        maps_.push_back(felt_map(explanation, pose.jacobian, static_cast<int>(i)));
  }

  Eigen::Index unknowns() const { return gains_ + kShape + kSymmetric * pose_count(); }
  Eigen::Index size() const { return 9 * pose_count() + kShape + kSymmetric * pose_count(); }
  double scale() const { return scale_; }

  // Gains in units of scale().
  Eigen::VectorXd residuals(const Eigen::VectorXd& x) const {
    Eigen::VectorXd r(size());
    Eigen::Index at = 0;
    for (Eigen::Index k = 0; k < pose_count(); ++k) {
      const PoseCompliance& pose = poses_[static_cast<std::size_t>(k)];
      const Matrix3 off = pose.A - exponential(log_hand(x, k)) * scale_ * felt(x, k);
      for (int j = 0; j < 3; ++j, at += 3) r.segment<3>(at) = off.col(j) / pose.deviation[j];
    }
    r.segment(at, kShape) = x.segment(gains_, kShape) / settings_.hand_anisotropy;
    at += kShape;
    for (Eigen::Index k = 0; k < pose_count(); ++k, at += kSymmetric) {
      const auto change = x.segment(gains_ + kShape + kSymmetric * k, kSymmetric);
      r.segment(at, kShape) = change.head(kShape) / settings_.hand_change;
      r[at + kShape] = change[kShape] / (std::sqrt(3.0) * settings_.grip_change);
    }
    return r;
  }

  Eigen::MatrixXd jacobian(const Eigen::VectorXd& x) const {
    constexpr double kStep = 1e-6;
    Eigen::MatrixXd J(size(), unknowns());
    for (Eigen::Index i = 0; i < unknowns(); ++i) {
      Eigen::VectorXd ahead = x, behind = x;
      ahead[i] += kStep, behind[i] -= kStep;
      J.col(i) = (residuals(ahead) - residuals(behind)) / (2.0 * kStep);
    }
    return J;
  }

  // A hand that gives way alike in every direction: then the gains are linear.
  Eigen::VectorXd start() const {
    Eigen::MatrixXd M(9 * pose_count(), gains_);
    Eigen::VectorXd a(9 * pose_count());
    for (Eigen::Index k = 0; k < pose_count(); ++k) {
      for (Eigen::Index i = 0; i < gains_; ++i) M.col(i).segment<9>(9 * k) = scale_ * map(k, i).reshaped();
      a.segment<9>(9 * k) = poses_[static_cast<std::size_t>(k)].A.reshaped();
    }
    Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns());
    x.head(gains_) = least_squares_columns(M, a);
    return x;
  }
  Matrix3 log_shape(const Eigen::VectorXd& x) const {
    Matrix3 sum = Matrix3::Zero();
    for (Eigen::Index i = 0; i < kShape; ++i)
      sum += x[gains_ + i] * symmetric_basis()[static_cast<std::size_t>(i)];
    return sum;
  }

 private:
  static double scale_of(std::span<const PoseCompliance> poses) {
    double sum = 0.0;
    for (const auto& pose : poses) sum += pose.A.squaredNorm();
    return std::sqrt(sum / (3.0 * static_cast<double>(poses.size())));
  }
  Eigen::Index pose_count() const { return static_cast<Eigen::Index>(poses_.size()); }
  const Matrix3& map(Eigen::Index k, Eigen::Index i) const {
    return maps_[static_cast<std::size_t>(k * gains_ + i)];
  }
  Matrix3 felt(const Eigen::VectorXd& x, Eigen::Index k) const {
    Matrix3 T = Matrix3::Zero();
    for (Eigen::Index i = 0; i < gains_; ++i) T += x[i] * map(k, i);
    return T;
  }
  Matrix3 log_hand(const Eigen::VectorXd& x, Eigen::Index k) const {
    Matrix3 sum = log_shape(x);
    for (Eigen::Index i = 0; i < kSymmetric; ++i)
      sum += x[gains_ + kShape + kSymmetric * k + i] * symmetric_basis()[static_cast<std::size_t>(i)];
    return sum;
  }

  std::span<const PoseCompliance> poses_;
  ForceCheckSettings settings_;
  Eigen::Index gains_;
  double scale_;
  std::vector<Matrix3> maps_;
};

}  // namespace

Matrix3 felt_map(const ForceExplanation& explanation, const Eigen::Matrix3Xd& jacobian, int i) {
  const int from = explanation.order[static_cast<std::size_t>(i)];
  if (!explanation.of_joints) return Vector3::Unit(i) * Vector3::Unit(from).transpose();
  // (J^T)^+ = (J J^T)^-1 J.
  const Matrix3 inverse = inverse_symmetric(jacobian * jacobian.transpose());
  return inverse * jacobian.col(i) * jacobian.col(from).transpose();
}

ForceFit fit_forces(std::span<const PoseCompliance> poses, const ForceExplanation& explanation,
                    const ForceCheckSettings& settings) {
  const ForceModel model(poses, explanation, settings);
  Eigen::VectorXd x = model.start();
  const auto evaluate = [&](const Eigen::VectorXd& at, NormalEquations<Eigen::Dynamic>* equations) {
    const Eigen::VectorXd r = model.residuals(at);
    if (equations) equations->add(model.jacobian(at), r);
    return r.squaredNorm();
  };
  const auto found = minimise(x, evaluate, {.most_iterations = 60, .tolerance = 1e-8});
  const Eigen::MatrixXd J = model.jacobian(x);
  const auto n = static_cast<Eigen::Index>(explanation.order.size());
  ForceFit fit;
  fit.explanation = explanation;
  fit.gains = model.scale() * x.head(n);
  const Eigen::MatrixXd information = gram(J);
  fit.covariance =
      model.scale() * model.scale() * covariance_from_information(information).topLeftCorner(n, n);
  fit.noise =
      model.scale() * covariance_from_information(information.topLeftCorner(n, n)).diagonal().cwiseSqrt();
  fit.hand = exponential(model.log_shape(x));
  fit.cost = found.cost;
  return fit;
}

}  // namespace palpate::calibration
