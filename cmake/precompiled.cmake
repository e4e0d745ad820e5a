# Headers from outside that most modules include are compiled once for all of them, and once more for the tests, with
# GoogleTest. None of ours: a change of one would compile everything anew. Files include what they use all the same
# (scripts/check-odr files compiles without this).
set(PALPATE_PRECOMPILED <algorithm> <array> <atomic> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory>
  <mutex> <optional> <span> <stdexcept> <string> <string_view> <thread> <utility> <vector> <Eigen/Core> <Eigen/Cholesky>
  <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <Eigen/QR> <Eigen/SVD> <fmt/format.h>)

# palpate_precompile(NAME HEADER ...): the target palpate_precompiled_NAME, of these headers beside the common ones.
function(palpate_precompile name)
  set(target palpate_precompiled_${name})
  file(CONFIGURE OUTPUT ${target}.cpp CONTENT "")
  add_library(${target} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp)
  target_link_libraries(${target} PRIVATE palpate_options Eigen3::Eigen fmt::fmt)
  target_precompile_headers(${target} PRIVATE ${PALPATE_PRECOMPILED} ${ARGN})
endfunction()

# The targets palpate_precompiled_modules and, where tests are built, palpate_precompiled_tests.
function(palpate_precompile_headers)
  find_package(Eigen3 REQUIRED NO_MODULE)
  find_package(fmt REQUIRED)
  palpate_precompile(modules)
  if(PALPATE_PYTHON_MODULES)
    palpate_precompile(independent)
    set_target_properties(palpate_precompiled_independent PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  if(PALPATE_TESTS)
    find_package(GTest REQUIRED)
    palpate_precompile(tests <gtest/gtest.h>)
    target_link_libraries(palpate_precompiled_tests PRIVATE GTest::gtest)
    target_compile_options(palpate_precompiled_tests PRIVATE ${PALPATE_TEST_OPTIONS})
  endif()
endfunction()
