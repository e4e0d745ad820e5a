#include "applications/palpation/nodule_odds.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

#include "palpate/experiment/normal.h"

namespace palpate::applications::palpation {
namespace {

// What nodules worth searching feel like: how large the logarithm of the force above them mostly is at most, fading as a bell over the distance beside it
// (docs/theory/trainee.md: 15 mm, its top 5 mm deep).
constexpr double kExpectedContrast = 0.30, kExpectedReach_m = 0.0073;
constexpr double kFaded = 2.5;  // reaches beyond which nothing is felt of it
// Standard deviations of the trend's coefficients, of logarithms: the mean is not known, slope and bend over kTrendUnit_m are
// those of organs that are as thick as this one is wide.
constexpr double kMeanSd = 10.0, kTrendSd = 0.08, kTrendUnit_m = 0.03;

}  // namespace

NoduleOdds::NoduleOdds(std::vector<PlanPlace> places, const std::vector<double>& felt,
                       const std::vector<double>& variances, bool level)
    : places_(std::move(places)) {
  const auto count = static_cast<Eigen::Index>(places_.size());
  Eigen::MatrixXd basis(count, level ? 1 : 6);
  Eigen::VectorXd values(count);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const PlanPlace p = places_[k] / kTrendUnit_m;
    basis(i, 0) = kMeanSd;
    if (!level) basis.row(i).tail(5) << p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
    if (!level) basis.row(i).tail(5) *= kTrendSd;
    values[i] = felt[k];
    covariance(i, i) = variances[k];
  }
  covariance += basis * basis.transpose();
  precision_ = covariance.llt().solve(Eigen::MatrixXd::Identity(count, count));
  weighed_ = precision_ * values;
}

NoduleOdds::Fit NoduleOdds::fit(const PlanPlace& at) const {
  std::vector<std::pair<Eigen::Index, double>> near;  // places that would feel it
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const double beside = (places_[i] - at).norm() / kExpectedReach_m;
    if (beside <= kFaded) near.emplace_back(static_cast<Eigen::Index>(i), std::exp(-0.5 * beside * beside));
  }
  Fit fit;
  for (const auto& [i, share] : near) {
    fit.felt += share * weighed_[i];
    for (const auto& [k, other] : near) fit.information += share * precision_(i, k) * other;
  }
  return fit;
}

// The bell's height is half a Gaussian: the integral over it in closed form.
double NoduleOdds::of(const PlanPlace& at) const {
  const Fit here = fit(at);
  constexpr double kPrior = 1.0 / (kExpectedContrast * kExpectedContrast);
  const double sharp = here.information + kPrior, z = here.felt / std::sqrt(sharp);
  return 0.5 * std::log(kPrior / sharp) + 0.5 * z * z + std::log(2.0 * experiment::normal_below(z));
}

double NoduleOdds::deviations(const PlanPlace& at) const {
  const Fit here = fit(at);
  return here.information > 0.0 ? here.felt / std::sqrt(here.information) : 0.0;
}

}  // namespace palpate::applications::palpation
