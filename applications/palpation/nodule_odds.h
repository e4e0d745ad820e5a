// How likely a nodule is at a place, given presses all over: the log-likelihood of one there over none.
//
// The logarithm of what is felt at a place is a smooth trend of the organ, what a nodule adds, and noise. The trend is a
// polynomial whose coefficients are unknown but small (Gaussian, sd in the source), so that a nodule near the rim is not
// taken for a slope. What a nodule adds is a bell of known width, whose height is
// not known but above 0 (half a Gaussian). Metres in the plan. Values; one thread.
//
// Source: generalised least squares; the trend's part of the covariance as in Rasmussen, Williams (2006), section 2.7.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::applications::palpation {

using PlanPlace = Eigen::Vector2d;

class NoduleOdds {
 public:
  // `felt`: mean logarithm at each place; `variances`: of these means. `level`: the organ has no trend but its mean.
  NoduleOdds(std::vector<PlanPlace> places, const std::vector<double>& felt,
             const std::vector<double>& variances, bool level);

  double of(const PlanPlace& at) const;
  // By how many standard deviations it is harder there than a smooth organ would be.
  double deviations(const PlanPlace& at) const;

 private:
  struct Fit {
    double felt = 0.0, information = 0.0;  // of the bell's height
  };
  Fit fit(const PlanPlace& at) const;

  std::vector<PlanPlace> places_;
  Eigen::MatrixXd precision_;
  Eigen::VectorXd weighed_;  // precision times felt
};

}  // namespace palpate::applications::palpation
