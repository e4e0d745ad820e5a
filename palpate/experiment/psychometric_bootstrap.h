// What a fitted psychometric function would scatter by if the experiment were done again, and whether the answers seen are
// such as it gives.
//
// Parametric bootstrap: answers drawn from the fitted curve at the same stimuli, each set fitted anew. The percentiles of
// threshold and spread are intervals that assume nothing of the likelihood's form; the deviances of the drawn sets are what
// the data's own is held against, as with few trials a level it follows no chi-square distribution. The same seed gives the
// same figures. Pure, any thread. Wrong use (exception): fewer than 40 repeats.
//
// Source: Wichmann, Hill (2001), "The psychometric function: II. Bootstrap-based confidence intervals and sampling" and I,
// section on the goodness of fit.
#pragma once

#include <cstdint>
#include <span>

#include "palpate/experiment/psychometric_fit.h"

namespace palpate::experiment {

struct BootstrapOptions {
  int repeats = 2000;
  std::uint64_t seed = 1;
  double level = kUsualLevel;
};

struct Bootstrap {
  Interval threshold, spread;
  double deviance_share =
      0.0;  // of drawn sets whose deviance is as large as the data's or larger; below 0.05 the curve's
            // form, or that all trials are alike, is in doubt
  int repeats = 0;
  int without_curve = 0;  // of them, drawn sets that tell no curve; they count where the search ended
};

Bootstrap bootstrap(const PsychometricFit& fit, std::span<const Level> levels, const TaskShape& task,
                    const BootstrapOptions& options = {});

}  // namespace palpate::experiment
