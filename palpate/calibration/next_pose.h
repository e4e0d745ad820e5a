// Which pose to measure next so that the calibrated arm predicts its tip best: greedy optimal design with an
// exchange pass, over poses that could be asked for.
//
// A pose that is not measured yet is an ArmObservation with readings, marker orientation (and place) and,
// where something is known of it, covariance; of its marker's place only where it lies matters. World, SI,
// radians. Each pose adds J^T S^-1 J to the information of the unknowns of `joint` (base, gains, offsets and
// what else `free` names), J the derivatives of the residual, S the covariance of the measured tip.
// Criteria: i_optimal, the mean over `workspace` of trace(J_w C J_w^T), the predicted squared error;
// d_optimal, log det C. What poses near one another err by in common (a tracker's systematic error, as the
// observation states it, else `shared_sd`) is in the prediction, marker turns included, and spreads the
// poses. Sources: Fedorov (1972), "Theory of Optimal Experiments" (greedy steps, exchange); Cook, Nachtsheim
// (1980), Technometrics 22 (the exchange in turns, as here); Borm, Menq (1991), Int. J. Robotics Research 10,
// and Sun, Hollerbach (2008), ICRA (measures for arms); Sacks, Ylvisaker (1966), Ann. Math. Statist. 37
// (designs under correlated errors). One thread per object; deterministic.
#pragma once

#include <memory>

#include "palpate/calibration/arm.h"

namespace palpate::calibration {

enum class DesignCriterion { i_optimal, d_optimal };

struct DesignOptions {
  ArmFree free{.gains = true, .offsets = true, .lengths = false, .tip = true, .dh = false};
  DesignCriterion criterion = DesignCriterion::i_optimal;
  double sd = 0.0002;           // m per axis, of a pose that brings no covariance
  double shared_sd = 0.00003;   // m per axis, of poses that state no systematic error. i_optimal only
  double shared_length = 0.15;  // m between markers at which the shared error's correlation is exp(-1/2)
};

class PoseDesign {
 public:
  // `arm`: the present estimate, at which derivatives are taken. `workspace`: readings of the places where
  // the tip shall be known; not empty.
  PoseDesign(const ArmSolution& arm, const std::vector<Eigen::VectorXd>& workspace,
             std::vector<device::ArmObservation> candidates, const DesignOptions& options = {});
  ~PoseDesign();
  PoseDesign(PoseDesign&&) noexcept;

  // A pose that has been measured.
  void take(const device::ArmObservation& pose);
  // The index of the candidate that helps most, not taken yet itself. A candidate may come again.
  std::size_t best() const;
  // `count` candidates: greedily, then by exchange, at most `passes` times through all of them, until no
  // exchange helps. In the order in which they help most. What was taken stays as it was.
  std::vector<std::size_t> plan(int count, int passes = 4) const;

  // With the poses taken so far, m: root mean square of the predicted tip's error over the workspace.
  double predicted_error() const;
  // The same with candidates `chosen` measured too.
  double predicted_error(const std::vector<std::size_t>& chosen) const;
  // At one place, m rms.
  double predicted_error_at(const Eigen::VectorXd& psi) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// Readings on a regular grid over ranges of the joints: `per_joint` values each, ends included.
std::vector<Eigen::VectorXd> joint_grid(const std::vector<std::array<double, 2>>& ranges, int per_joint);

}  // namespace palpate::calibration
