// A sampled motion read between its samples, with its rate of change.
//
// Local cubic regression with Gaussian weights (Fan, Gijbels 1996, section 3.1): at time t the samples within
// four widths are fitted by a cubic in time; its value and slope at t are the answer. Between two samples a
// straight line would average their noise more or less, depending on where t lies, and least squares on a delay
// would be drawn to where it averages most: with both streams at one rate, to the middle between samples. With a
// width of 1.2 sampling periods the noise of the value is the same everywhere to some percent, and that of value
// and slope are uncorrelated. Pure, no thread rule.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::calibration {

// Three quarters of a stream's steps are not longer; 0 for fewer than two times. Times rise.
double sampling_period(const std::vector<double>& time_s);

class SmoothStream {
 public:
  // A row of `channels` for each time; times rise. `width_s`: standard deviation of the weights, at least 1.2
  // sampling periods are taken.
  SmoothStream(std::vector<double> time_s, Eigen::MatrixXd channels, double width_s = 0.0);

  // False in gaps and at the ends, where a cubic would guess.
  bool at(double time_s, Eigen::RowVectorXd& value, Eigen::RowVectorXd& slope) const;

  const std::vector<double>& time_s() const { return time_s_; }
  const Eigen::MatrixXd& channels() const { return channels_; }

 private:
  std::vector<double> time_s_;
  Eigen::MatrixXd channels_;
  double period_ = 0.0, width_ = 0.0;
};

}  // namespace palpate::calibration
