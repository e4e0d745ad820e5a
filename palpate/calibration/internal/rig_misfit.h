// The whitened differences between what was observed and what a state of the rig predicts, and their size once the
// calibration's own errors are allowed for.
//
// e = W (observed - predicted), W'W the inverse of the devices' covariance; the size of e is e' (I + A A')^-1 e with A
// the errors' derivative at the rig's own state, by Woodbury's identity through a matrix of the errors' rank. Internal
// to this module. One thread; references to the observations, which must outlive it.
#pragma once

#include <vector>

#include "palpate/calibration/internal/rig_state.h"

namespace palpate::calibration {

class RigMisfit {
 public:
  RigMisfit(const rig::Rig& rig, const RigObservations& observed, const VerificationOptions& options);

  Eigen::Index rows() const { return rows_; }
  Eigen::Index errors() const { return A_.cols(); }
  const RigState& rig_state() const { return state_; }
  // The errors u upon a state.
  RigState errors_on(const RigState& at, const Eigen::VectorXd& u) const {
    return with_errors(at, root_ * u);
  }
  RigState with(const Eigen::VectorXd& u) const { return errors_on(state_, u); }

  Eigen::VectorXd differences(const RigState& state) const;
  // Columns J beside the errors: J' S^-1 J and J' S^-1 e.
  Eigen::MatrixXd product(const Eigen::MatrixXd& J, const Eigen::MatrixXd& e) const;
  // Of the errors u (first) and of further unknowns with these columns: mean (unknowns are 0 at e) and covariance.
  struct Posterior {
    Eigen::VectorXd mean;
    Eigen::MatrixXd covariance;
  };
  Posterior posterior(const Eigen::MatrixXd& J, const Eigen::VectorXd& e) const;
  // The differences that these leave: on average a little shorter than the devices' noise.
  Eigen::VectorXd remaining(const Eigen::MatrixXd& J, const Eigen::VectorXd& e) const;
  // Covariance of the differences that are not whitened, rows `from` on, where nothing has changed: devices and errors.
  Eigen::MatrixXd spread(Eigen::Index from, Eigen::Index count) const;

  struct Rows {
    Eigen::Index first = 0, count = 0;
  };
  Rows rest() const { return rest_; }
  Rows held() const { return held_; }
  Rows touched() const { return touched_; }
  Rows seen() const { return seen_; }
  Rows delay() const { return delay_; }
  // What the tracker's noise did to a frame's marker, as the dots in its picture tell for a state of the rig: the step to
  // the true pose (rad, m) and its covariance.
  struct MarkerStep {
    Vector6 mean = Vector6::Zero();
    Matrix6 covariance = Matrix6::Zero();
  };
  MarkerStep marker_step(const HeadFrame& frame, const RigState& state) const;
  // Not whitened.
  Eigen::VectorXd raw(const RigState& state) const;

 private:
  void add(const Eigen::MatrixXd& covariance);
  void add_frames();
  Eigen::MatrixXd dots_covariance(const HeadFrame& frame) const;
  Matrix3 held_covariance(const HeldStylus& held, const VerificationOptions& options) const;

  const RigObservations& observed_;
  RigState state_;
  double pixel_variance_ = 0.0;
  Eigen::VectorXd rest_then_;
  double delay_then_ = 0.0;
  Eigen::MatrixXd root_;
  struct Block {
    Eigen::MatrixXd covariance, whitener;
  };
  std::vector<Block> blocks_;
  Eigen::Index rows_ = 0;
  Rows rest_, held_, touched_, seen_, delay_;
  Eigen::MatrixXd A_, inverse_;  // derivative of the differences by u; (I + A'A)^-1
};

// d f / d x at 0 by differences of `step`.
template <typename F>
Eigen::MatrixXd derivative(Eigen::Index unknowns, double step, const F& f) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  Eigen::MatrixXd J;
  for (Eigen::Index i = 0; i < unknowns; ++i) {
    x[i] = step;
    const Eigen::VectorXd ahead = f(x);
    x[i] = -step;
    const Eigen::VectorXd behind = f(x);
    x[i] = 0.0;
    if (J.cols() == 0) J.resize(ahead.size(), unknowns);
    J.col(i) = (ahead - behind) / (2.0 * step);
  }
  return J;
}

}  // namespace palpate::calibration
