// Tables of trials into the fit of a psychometric curve, and as the file of an experiment that is taken up.
#include <vector>

#include "fuzz/check.h"
#include "palpate/experiment/experiment_run.h"
#include "palpate/experiment/observation_table.h"
#include "palpate/experiment/psychometric_fit.h"
#include "palpate/experiment/trial_file.h"

namespace palpate::fuzz {

Refusals trials(std::string_view file) {
  Refusals refusals;
  if (file.starts_with("# palpate trials")) {
    const auto conditions = experiment::example_conditions(experiment::Method::constant_stimuli);
    const auto held = experiment::parse_trials(file, "trials.csv", conditions);
    if (answered(held, refusals)) {
      experiment::ExperimentRun run(conditions, held->seed);
      (void)answered(run.take_up(held->records, "trials.csv"), refusals);
    }
  }
  const auto table = experiment::parse_observations(file, "trials.csv", {});
  if (!answered(table, refusals)) return refusals;
  for (const auto& group : table->groups) {
    auto levels = group.levels;
    cut(levels);
    for (const auto rule : {experiment::GuessRule::fixed, experiment::GuessRule::equals_lapse}) {
      const auto fit = experiment::fit_psychometric(levels, {.rule = rule});
      if (!answered(fit, refusals)) continue;
      hold_finite(fit->curve.threshold, "a threshold is finite");
      hold_finite(fit->curve.spread, "a spread is finite");
      hold_finite(fit->deviance, "a deviance is finite");
      hold(fit->threshold.low <= fit->curve.threshold && fit->curve.threshold <= fit->threshold.high,
           "a threshold lies in its interval");
    }
  }
  return refusals;
}

}  // namespace palpate::fuzz
