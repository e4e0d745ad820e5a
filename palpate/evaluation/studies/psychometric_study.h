// Psychometric curves of a table of trials: who could tell what from what, fitted, with intervals, as figures and as a page.
//
// The table is an experiment's file of trials or a person's own (palpate/experiment/observation_table.h). Groups whose answers
// tell no curve are named with the reason and left without one. The same seed gives the same figures. Errors: wrong use for a
// table that is none; refused where no group tells a curve.
#pragma once

#include <filesystem>

#include "palpate/evaluation/studies/study.h"
#include "palpate/experiment/fit_report.h"
#include "palpate/experiment/observation_table.h"

namespace palpate::evaluation::studies {

struct PsychometricOptions {
  std::filesystem::path trials;
  experiment::ObservationOptions columns;
  experiment::TaskShape task;
  experiment::BootstrapOptions bootstrap;
  RepeatSettings repeats;  // for its progress alone
};

Expected<StudyResult> study_psychometric(const PsychometricOptions& options);

}  // namespace palpate::evaluation::studies
