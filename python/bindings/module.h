// What the files of palpate._core add to it.
#pragma once

#include <pybind11/pybind11.h>

namespace palpate::python {

void add_calibrations(pybind11::module_& module);
void add_arm(pybind11::module_& module);
void add_files(pybind11::module_& module);
void add_recordings(pybind11::module_& module);

}  // namespace palpate::python
