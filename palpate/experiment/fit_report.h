// The fits of an experiment's groups as figures and as JSON. Pure, any thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/experiment/observation_table.h"
#include "palpate/experiment/psychometric_bootstrap.h"
#include "palpate/experiment/psychometric_fit.h"

namespace palpate::experiment {

struct GroupFit {
  ObservationGroup group;
  DataVerdict verdict = DataVerdict::no_trials;
  std::string refusal;                 // in words, where there is no fit
  std::optional<PsychometricFit> fit;  // where the verdict is usable
  std::optional<Bootstrap> again;      // with the fit
};

GroupFit fit_group(const ObservationGroup& group, const TaskShape& task, const BootstrapOptions& options);

// A key for each figure; an end of an interval that the data do not bound is null. Stimuli are in the table's unit.
//   by {COLUMN: VALUE}, trials, levels [{stimulus, positives, trials}], refused {code, message} or
//   threshold, threshold_interval, threshold_bootstrap, spread, spread_interval, spread_bootstrap, lapse, lapse_at_bound,
//   stimulus_at_75, deviance, deviance_share, bootstrap_without_curve, and of a comparison weber_fraction with its interval
Json json_of(const GroupFit& fit, const TaskShape& task);

// A line for a person.
std::string line_of(const GroupFit& fit, const TaskShape& task);

}  // namespace palpate::experiment
