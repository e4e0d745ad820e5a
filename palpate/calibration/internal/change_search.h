// Which change since the calibration explains what is observed: the fit of each and the choice among them. Internal to
// this module. Pure functions, no thread rule.
#pragma once

#include <vector>

#include "palpate/calibration/internal/rig_misfit.h"

namespace palpate::calibration {

// Several changes at once, their amounts one after the other, each in units of its usual size.
struct ChangeFit {
  std::vector<Change> changes;
  Eigen::VectorXd amounts;   // scaled
  Eigen::MatrixXd jacobian;  // of the differences there
  double cost = 0.0;         // e' S^-1 e
  double occam = 0.0;        // log det(I + J' S^-1 J) of the last change, beside the others
};

RigState changed(const RigState& at, const std::vector<Change>& changes, const Eigen::VectorXd& amounts);
ChangeFit fit_changes(const RigMisfit& misfit, const std::vector<Change>& changes,
                      const Eigen::VectorXd& start);

struct ChangeSearch {
  ChangeFit found;                 // no changes: none
  std::vector<FoundChange> told;   // of these, in the order they were found
  std::vector<FoundChange> tried;  // each alone
};

ChangeSearch search_changes(const RigMisfit& misfit, const VerificationOptions& options);

}  // namespace palpate::calibration
