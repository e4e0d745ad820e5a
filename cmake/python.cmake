# Whether the Python package is built (python/), and with which modules: where the libraries are built and pybind11 is
# installed. Its extension modules are shared libraries, so the modules they hold are compiled as position-independent
# code; all others stay as they are.
option(PALPATE_PYTHON "Build the Python package where pybind11 is installed" ON)
set(PALPATE_PYTHON_INTERPRETER /usr/bin/python3 CACHE FILEPATH "Whose package it is: Debian's own, which has Debian's numpy")
set(PALPATE_PYTHON_MODULES "")
add_custom_target(palpate_python ALL)  # of nothing where it is left out

if(PALPATE_PYTHON AND PALPATE_LIBRARY AND NOT PALPATE_SANITIZE AND NOT PALPATE_PARTS STREQUAL "physics")
  execute_process(COMMAND ${PALPATE_PYTHON_INTERPRETER} -c
      "import sysconfig as s; print(s.get_path('include'), s.get_config_var('EXT_SUFFIX'), sep=';')"
    OUTPUT_VARIABLE told OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed ERROR_QUIET)
  find_path(PYBIND11_INCLUDE pybind11/pybind11.h)
  if(failed)
    message(STATUS "python: the package is left out, for ${PALPATE_PYTHON_INTERPRETER} does not run")
    return()
  endif()
  list(GET told 0 include)
  if(NOT PYBIND11_INCLUDE OR NOT EXISTS ${include}/Python.h)
    message(STATUS "python: the package is left out, for pybind11 or Python's headers are not here (pybind11-dev, python3-dev; scripts/setup)")
  else()
    list(GET told 1 PALPATE_PYTHON_SUFFIX)
    set(PALPATE_PYTHON_INCLUDES ${PYBIND11_INCLUDE} ${include})
    set(PALPATE_PYTHON_MODULES core math time figures experiment device rig formats calibration/noise calibration calibration/findings
      vision record scene transport)
    # Debian's Python looks there below /usr, a prefix of one's own needs PYTHONPATH.
    set(PALPATE_PYTHON_FOLDER lib/python3/dist-packages CACHE STRING "Where the Python package is installed, below the prefix")
  endif()
endif()
