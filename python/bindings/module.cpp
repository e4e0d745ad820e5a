// palpate._core: the calibrations that need no camera's picture, and files. The Python package around it is what people
// use.
#include "python/bindings/module.h"

#include "python/bindings/conversions.h"

PYBIND11_MODULE(_core, module) {
  palpate::python::raise_failures();
  palpate::python::add_calibrations(module);
  palpate::python::add_arm(module);
  palpate::python::add_files(module);
  palpate::python::add_recordings(module);
}
