// What the files of palpate._experiment add to it.
#pragma once

#include <pybind11/pybind11.h>

#include "palpate/experiment/staircase.h"

namespace palpate::python {

void add_psychometric(pybind11::module_& module);
void add_staircases(pybind11::module_& module);
void add_experiment_runs(pybind11::module_& module);

// None, or what the staircase says of its threshold: stimulus, log_sd, reversals.
pybind11::object threshold_of(const experiment::Staircase& staircase);

}  // namespace palpate::python
