// The fits of an experiment's groups as plots and as a table. Pure, any thread.
#pragma once

#include <span>
#include <string>

#include "palpate/experiment/fit_report.h"
#include "palpate/figures/plot.h"
#include "palpate/figures/section.h"

namespace palpate::experiment {

// Answers, curve and the interval of the threshold over the stimulus, whose name stands at the axis.
figures::Plot plot_of(const GroupFit& fit, const TaskShape& task, const std::string& stimulus);

// A row for each group.
figures::Table table_of(std::span<const GroupFit> fits, const TaskShape& task);

}  // namespace palpate::experiment
