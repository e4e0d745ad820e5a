#include "palpate/calibration/internal/shift_fit.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/internal/long_run_variance.h"
#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kFreedoms = 5.0;          // of the noise's t distribution
constexpr double kStillness = 1e-8;        // s
constexpr std::size_t kMostRows = 20'000;  // more tell little, and take long
constexpr int kMostShiftRounds = 60;
constexpr Eigen::Index kMostMemory = 40;  // coefficients of the autoregression

// The rows compared at one shift. The relation of both streams is eliminated: residuals and slopes hold no part
// that the features explain.
struct ShiftRows {
  Eigen::MatrixXd features;  // with a column of ones
  Eigen::MatrixXd response, read_slope;
};

class Fit {
 public:
  Fit(const ShiftProblem& problem, double shift_s, double reach_s) : problem_(problem) {
    Eigen::RowVectorXd value, slope;
    for (std::size_t i = 0; i < problem.time_s.size(); i += 1 + problem.time_s.size() / kMostRows) {
      const auto readable = [&](double by) {
        return problem.read.at(problem.time_s[i] + shift_s + by, value, slope);
      };
      if (readable(0.0) && readable(-reach_s) && readable(reach_s)) at_.push_back(i);
    }
    weight_ = Eigen::VectorXd::Ones(size());
    features_ = 1 + (problem.sampled_responds ? problem.read.channels().cols() : problem.sampled.cols());
    responses_ = problem.sampled_responds ? problem.sampled.cols() : problem.read.channels().cols();
    unscatter_ = Eigen::MatrixXd::Identity(responses_, responses_);
  }

  Eigen::Index size() const { return static_cast<Eigen::Index>(at_.size()); }
  bool enough() const { return size() >= 20 && size() >= 2 * features_ + 4; }

  // A mean square over the rows, whitened and weighted; the solver's equations where they are asked for.
  double cost(double shift_s, NormalEquations<1>* equations) {
    regress(shift_s);
    const auto n = static_cast<double>(size());
    if (equations) {
      const Eigen::MatrixXd J = whitened(slope_), r = whitened(residual_);
      equations->JtJ(0, 0) = weight_.dot(J.cwiseProduct(J).rowwise().sum()) / n;
      equations->Jtr(0) = weight_.dot(J.cwiseProduct(r).rowwise().sum()) / n;
    }
    return weight_.dot(whitened(residual_).rowwise().squaredNorm()) / n;
  }

  // Scatter and weights of the residuals at a shift. The scatter has a floor: exact data would make it singular.
  void renew(double shift_s) {
    regress(shift_s);
    const auto n = static_cast<double>(size());
    Eigen::MatrixXd scatter = residual_.transpose() * weight_.asDiagonal() * residual_ / n;
    const Eigen::MatrixXd spread = rows_.response.rowwise() - rows_.response.colwise().mean();
    const double floor = 1e-16 * spread.squaredNorm() / n;
    scatter.diagonal().array() += std::max(floor, 1e-300);
    const auto eigen = symmetric_eigen(scatter);
    unscatter_ = eigen.vectors * eigen.values.cwiseMax(floor).cwiseSqrt().cwiseInverse().asDiagonal();
    const Eigen::VectorXd squared = whitened(residual_).rowwise().squaredNorm();
    const auto m = static_cast<double>(responses_);
    weight_ = (kFreedoms + m) * (kFreedoms + squared.array()).inverse();
  }

  ShiftFit judged(double shift_s) {
    renew(shift_s);
    ShiftFit fit;
    fit.shift_s = shift_s;
    fit.rows = static_cast<int>(size());
    fit.overlap_s = problem_.time_s[at_.back()] - problem_.time_s[at_.front()];
    const Eigen::RowVectorXd mean = weight_.transpose() * rows_.response / weight_.sum();
    const double total = weight_.dot((rows_.response.rowwise() - mean).rowwise().squaredNorm());
    fit.unexplained = std::min(1.0, weight_.dot(residual_.rowwise().squaredNorm()) / std::max(total, 1e-300));
    fit.correlation = std::sqrt(1.0 - fit.unexplained);
    judge_deviation(fit);
    return fit;
  }

 private:
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& rows) const { return rows * unscatter_; }

  void read(double shift_s) {
    const auto n = size();
    const Eigen::Index width = problem_.read.channels().cols();
    Eigen::MatrixXd value(n, width), slope(n, width), sampled(n, problem_.sampled.cols());
    Eigen::RowVectorXd v, s;
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto from = at_[static_cast<std::size_t>(i)];
      // A step beyond the reach ends where nothing can be read: it costs as much as no fit at all.
      if (!problem_.read.at(problem_.time_s[from] + shift_s, v, s)) v.setZero(width), s.setZero(width);
      value.row(i) = v, slope.row(i) = s;
      sampled.row(i) = problem_.sampled.row(static_cast<Eigen::Index>(from));
    }
    rows_.read_slope = slope;
    rows_.features.setOnes(n, features_);
    rows_.features.leftCols(features_ - 1) = problem_.sampled_responds ? value : sampled;
    rows_.response = problem_.sampled_responds ? sampled : value;
  }

  // What the features explain, taken off; their relation comes along.
  Eigen::MatrixXd unexplained_by_features(const Eigen::MatrixXd& columns, Eigen::MatrixXd* relation) const {
    const Eigen::MatrixXd weighted = weight_.asDiagonal() * rows_.features;
    const Eigen::MatrixXd found =
        pseudo_inverse_symmetric(weighted.transpose() * rows_.features) * (weighted.transpose() * columns);
    if (relation) *relation = found;
    return columns - rows_.features * found;
  }

  void regress(double shift_s) {
    read(shift_s);
    Eigen::MatrixXd relation;
    residual_ = unexplained_by_features(rows_.response, &relation);
    relation_ = relation.topRows(features_ - 1);
    slope_ = unexplained_by_features(
        problem_.sampled_responds ? Eigen::MatrixXd(-rows_.read_slope * relation_) : rows_.read_slope,
        nullptr);
  }

  // The same derivative of the residuals by the slopes of the sampled stream; where it has none, the read one's.
  Eigen::MatrixXd slope_by_sampled() const {
    Eigen::MatrixXd slopes =
        problem_.sampled_responds ? Eigen::MatrixXd(-rows_.read_slope * relation_) : rows_.read_slope;
    Eigen::RowVectorXd value, slope;
    for (Eigen::Index i = 0; i < size(); ++i)
      if (problem_.sampled_smooth.at(problem_.time_s[at_[static_cast<std::size_t>(i)]], value, slope))
        slopes.row(i) =
            problem_.sampled_responds ? Eigen::RowVectorXd(-slope) : Eigen::RowVectorXd(slope * relation_);
    return slopes;
  }

  void judge_deviation(ShiftFit& fit) const {
    const auto n = static_cast<double>(size()), m = static_cast<double>(responses_);
    const Eigen::MatrixXd g = whitened(slope_), r = whitened(residual_);
    const Eigen::MatrixXd e = weight_.asDiagonal() * r;
    // Derivative of w r by r, in the mean over the rows.
    const double sensitivity = weight_.mean() - 2.0 * e.squaredNorm() / (n * (kFreedoms + m) * m);
    const double A = sensitivity * g.cwiseProduct(whitened(slope_by_sampled())).sum();
    double white = 0.0, correlated = 0.0, memory = 0.0, energy = 0.0;
    for (Eigen::Index c = 0; c < responses_; ++c) {
      const double variance = e.col(c).squaredNorm() / n, gg = g.col(c).squaredNorm();
      const auto noise = fit_autoregression(e.col(c), kMostMemory);
      white += variance * gg;
      correlated += variance_of_sum(noise, g.col(c));
      memory += gg * variance * memory_of(noise, variance);
      energy += gg * variance;
    }
    const double step = fit.overlap_s / std::max(1.0, n - 1.0);
    const double samples = memory / std::max(energy, 1e-300);
    fit.memory_s = samples * step;
    fit.effective_rows = n / (1.0 + 2.0 * samples);
    const Eigen::VectorXd scores = g.cwiseProduct(e).rowwise().sum();
    const auto reach = static_cast<Eigen::Index>(std::min(n / 8.0, 4.0 * samples + 2.0));
    const double direct = bartlett_sum(scores, reach);
    const double scatter =
        std::sqrt(4.0 / 3.0 * static_cast<double>(reach + 1) / n);  // of `direct`, relative
    double variance = correlated;
    if (direct * (1.0 - 2.0 * scatter) > variance) variance = direct;
    // What the features and the shift have taken from so many independent residuals.
    const auto k = static_cast<double>(features_) + 1.0;
    const double independent = std::max(fit.effective_rows, 2.0 * k);
    variance *= independent / (independent - k);
    fit.grown_by = std::sqrt(variance / std::max(white, 1e-300));
    fit.std_s = A > 0.0 ? std::sqrt(variance) / A : std::numeric_limits<double>::infinity();
  }

  const ShiftProblem& problem_;
  std::vector<std::size_t> at_;  // rows of the sampled stream
  Eigen::Index features_ = 0, responses_ = 0;
  Eigen::VectorXd weight_;
  Eigen::MatrixXd unscatter_;  // residual rows times this are white
  ShiftRows rows_;
  Eigen::MatrixXd residual_, slope_, relation_;
};

}  // namespace

std::optional<ShiftFit> fit_shift(const ShiftProblem& problem, double shift_s, double reach_s) {
  Fit fit(problem, shift_s, reach_s);
  if (!fit.enough()) return std::nullopt;
  Eigen::Matrix<double, 1, 1> x(shift_s);
  for (int round = 0; round < kMostShiftRounds; ++round) {
    fit.renew(x[0]);
    const double before = x[0];
    minimise(x,
             [&](const Eigen::Matrix<double, 1, 1>& at, NormalEquations<1>* equations) {
               return fit.cost(at[0], equations);
             },
             {.most_iterations = 20});
    if (std::abs(x[0] - shift_s) > reach_s) return std::nullopt;
    if (std::abs(x[0] - before) < kStillness && round >= 3) break;
  }
  return fit.judged(x[0]);
}

}  // namespace palpate::calibration
