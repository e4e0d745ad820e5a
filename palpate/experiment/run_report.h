// What an experiment has found, from its answers: the curve of each cell, the threshold of each staircase. Pure, any thread.
#pragma once

#include <span>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/experiment/conditions.h"
#include "palpate/experiment/experiment_run.h"
#include "palpate/experiment/fit_report.h"
#include "palpate/experiment/observation_table.h"

namespace palpate::experiment {

// The answers that count, a group for each cell, in the order of cells_of(); one without answers has no levels.
std::vector<ObservationGroup> groups_of(const Conditions& conditions, std::span<const TrialRecord> records);

// A list with an entry for each staircase, as json_of(ExperimentRun) has it; empty of constant stimuli.
Json json_of_staircases(const ExperimentRun& run);

// A key for each figure:
//   name, conditions (their hash), seed, finished, trials, practice, excluded,
//   groups (as json_of(GroupFit)), staircases [{by, track, share_sought, trials, trials_at_limit, reversals, threshold, log_sd}]
// A staircase with too few reversals has a threshold of null.
Json json_of(const ExperimentRun& run, std::span<const TrialRecord> records,
             const BootstrapOptions& options = {});

}  // namespace palpate::experiment
