# The layers: a module may use modules of lower layers only. Configuring fails where a link, an #include or a
# namespace says otherwise. docs/architecture.md explains what lives where.
#
# A module's name is its folder without the `palpate/` in front: core is palpate/core, drivers/cameras is drivers/cameras.
set(PALPATE_LAYER_0 core)
set(PALPATE_LAYER_1 math time figures)
set(PALPATE_LAYER_2 device)
set(PALPATE_LAYER_3 scene rig)
set(PALPATE_LAYER_4 physics calibration/noise transport render sim/config)
set(PALPATE_LAYER_5 calibration haptics applications/pingpong applications/touch)
set(PALPATE_LAYER_6 vision drivers/laboratory drivers/openigtlink drivers/openhaptics drivers/cameras applications)
set(PALPATE_LAYER_7 calibration/session server/physics server/graphics sim)
set(PALPATE_LAYER_8 desktop)
set(PALPATE_LAYER_9 evaluation)
set(PALPATE_LAYER_10 server/session sim/lockstep evaluation/report)
set(PALPATE_LAYER_11 evaluation/studies)
set(PALPATE_LAYER_12 tools/demo tools/doctor)
set(PALPATE_LAYER_13 tools/commands)
set(PALPATE_LAYER_COUNT 14)

# Where threads or processes meet: the thread sanitizer runs the tests of these (target threaded_tests, label threaded).
set(PALPATE_THREADED core time scene device transport drivers/laboratory drivers/openigtlink drivers/openhaptics drivers/cameras haptics
  server/physics)

# Where memory is at risk from what others send, from parsers and from raw buffers: the address sanitizer runs the tests
# of these for every change (target checked_tests, label checked), and those of all modules in scripts/long.
set(PALPATE_CHECKED core device scene rig physics transport render sim/config haptics applications/pingpong applications/touch
  drivers/laboratory drivers/openigtlink drivers/openhaptics drivers/cameras server/physics server/graphics)

# Tests that take long: hundreds of repeats for statistics, and long runs of what shorter tests run, too. They have the
# label long; .ci/run leaves them to scripts/long. A regular expression each.
set(PALPATE_LONG_TESTS "Statistics\\." "TenMillionTicks" "^Program\\.(soak|live_poses|two_hosts)$")

# PALPATE_PARTS=physics: the physics server alone, without code of tracker, camera and graphics, and without the
# libraries these need (OpenCV, OpenGL, EGL). A module that is not listed here cannot be linked there.
set(PALPATE_PHYSICS_PARTS core math time figures device scene rig physics transport sim/config haptics drivers/laboratory drivers/openhaptics
  applications/pingpong applications/touch applications server/physics tools/commands)

set(PALPATE_ALL_MODULES "")
math(EXPR palpate_highest_layer "${PALPATE_LAYER_COUNT} - 1")
foreach(layer RANGE 0 ${palpate_highest_layer})
  foreach(module IN LISTS PALPATE_LAYER_${layer})
    list(APPEND PALPATE_ALL_MODULES ${module})
    string(REPLACE "/" "_" name ${module})
    set(PALPATE_LAYER_OF_${name} ${layer})
  endforeach()
endforeach()

# The folder of a module, from the project's root; also its include path.
function(palpate_folder_of module result)
  if(NOT module MATCHES "^(drivers|applications|tools)(/|$)")
    string(PREPEND module "palpate/")
  endif()
  set(${result} ${module} PARENT_SCOPE)
endfunction()

# palpate_module(DEPENDS core math ... LIBRARIES Eigen3::Eigen ...)
# Called in the CMakeLists.txt of a module's folder. Sources are the folder's *.cpp, tests its *_test.cpp; internal/ holds
# what no other module may include and what is not installed.
# DEPENDS names lower modules, TEST_DEPENDS those that only the tests need; LIBRARIES what comes from outside,
# TEST_LIBRARIES what only the tests need of that. The target is palpate_<name>, to others palpate::<name>.
function(palpate_module)
  cmake_parse_arguments(ARG "" "" "DEPENDS;TEST_DEPENDS;LIBRARIES;TEST_LIBRARIES;SOURCES" ${ARGN})
  file(RELATIVE_PATH module ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  string(REGEX REPLACE "^palpate/" "" module ${module})
  string(REPLACE "/" "_" name ${module})
  set(target palpate_${name})
  file(GLOB sources CONFIGURE_DEPENDS *.cpp internal/*.cpp)
  file(GLOB tests CONFIGURE_DEPENDS *_test.cpp internal/*_test.cpp)
  if(tests)
    list(REMOVE_ITEM sources ${tests})
  endif()
  list(APPEND sources ${ARG_SOURCES})
  if(sources)
    add_library(${target} STATIC ${sources})
    set(scope PUBLIC)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(palpate::${name} ALIAS ${target})
  # In this tree only: what is installed hands on no warnings, sanitizers or folders of ours.
  target_link_libraries(${target} ${scope} $<BUILD_INTERFACE:palpate_options>)
  target_compile_features(${target} ${scope} cxx_std_20)
  set(test_targets "")
  foreach(dependency IN LISTS ARG_DEPENDS ARG_TEST_DEPENDS)
    string(REPLACE "/" "_" dependency_name ${dependency})
    if(NOT PALPATE_LAYER_OF_${dependency_name} LESS PALPATE_LAYER_OF_${name})
      message(FATAL_ERROR "layers: ${module} (layer ${PALPATE_LAYER_OF_${name}}) may not use ${dependency} "
        "(layer ${PALPATE_LAYER_OF_${dependency_name}}); move the shared data one layer down")
    endif()
    if(dependency IN_LIST ARG_DEPENDS)
      target_link_libraries(${target} ${scope} palpate_${dependency_name})
    else()
      list(APPEND test_targets palpate_${dependency_name})
    endif()
  endforeach()
  target_link_libraries(${target} ${scope} ${ARG_LIBRARIES})
  if(PALPATE_TESTS AND tests)
    add_executable(${target}_test ${tests})
    target_link_libraries(${target}_test PRIVATE ${target} ${test_targets} ${ARG_TEST_LIBRARIES} GTest::gtest GTest::gtest_main)
    target_compile_definitions(${target}_test PRIVATE PALPATE_DATA_DIR="${PROJECT_SOURCE_DIR}/data")
    # Tests are compiled once and read the same headers of GoogleTest and the module.
    set_target_properties(${target}_test PROPERTIES UNITY_BUILD_BATCH_SIZE 16)
    target_compile_options(${target}_test PRIVATE ${PALPATE_TEST_OPTIONS})
    set(labels ${name})
    if(module IN_LIST PALPATE_THREADED)
      list(APPEND labels threaded)
      add_dependencies(threaded_tests ${target}_test)
    endif()
    if(module IN_LIST PALPATE_CHECKED)
      list(APPEND labels checked)
      add_dependencies(checked_tests ${target}_test)
    endif()
    palpate_discover_tests(${target}_test LABELS ${labels})
  endif()
endfunction()

# palpate_discover_tests(target LABELS ... RESOURCE_LOCK name): the GoogleTest tests of a program, each with these labels,
# and with `long` where PALPATE_LONG_TESTS names it.
function(palpate_discover_tests target)
  cmake_parse_arguments(ARG "" "RESOURCE_LOCK" "LABELS" ${ARGN})
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST TEST_LIST ${target}_found PROPERTIES TIMEOUT 300
    ENVIRONMENT "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/cmake/tsan.supp")
  # Which tests there are is known when ctest starts: it reads this after it has asked the program.
  set(settings ${CMAKE_CURRENT_BINARY_DIR}/${target}_labels.cmake)
  list(JOIN PALPATE_LONG_TESTS "|" long)
  if(ARG_RESOURCE_LOCK)
    set(lock "RESOURCE_LOCK ${ARG_RESOURCE_LOCK}")
  endif()
  file(CONFIGURE OUTPUT ${settings} @ONLY CONTENT [[
foreach(test IN LISTS @target@_found)
  set(labels "@ARG_LABELS@")
  if(test MATCHES [==[@long@]==])
    list(APPEND labels long)
  endif()
  set_tests_properties("${test}" PROPERTIES LABELS "${labels}" @lock@)
endforeach()
]])
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${settings})
endfunction()

function(palpate_add_layers)
  if(PALPATE_TESTS)
    find_package(GTest REQUIRED)
    add_custom_target(threaded_tests)
    add_custom_target(checked_tests)
    add_library(palpate_allocation_count OBJECT tests/allocation_count.cpp)
    target_link_libraries(palpate_allocation_count PRIVATE palpate_options)
  endif()
  set(modules ${PALPATE_ALL_MODULES})
  set(folders examples tests fuzz)
  if("${PALPATE_PARTS}" STREQUAL "physics")
    set(modules ${PALPATE_PHYSICS_PARTS})
    set(folders tests)
  elseif(NOT "${PALPATE_PARTS}" MATCHES "^(all)?$")
    message(FATAL_ERROR "PALPATE_PARTS is '${PALPATE_PARTS}'; all or physics is expected")
  endif()
  foreach(module IN LISTS modules)
    palpate_folder_of(${module} folder)
    if(EXISTS ${PROJECT_SOURCE_DIR}/${folder}/CMakeLists.txt)
      add_subdirectory(${folder} modules/${module})  # leaves <build>/palpate to the program
    endif()
  endforeach()
  foreach(folder IN LISTS folders)
    if(EXISTS ${PROJECT_SOURCE_DIR}/${folder}/CMakeLists.txt)
      add_subdirectory(${folder} modules/${folder})
    endif()
  endforeach()
  if(PALPATE_BENCH)
    add_subdirectory(bench)
  endif()
endfunction()

# The other half of the rule: what the sources include. A header of a neighbour or of a higher layer stops
# the configuration with file, line and reason.
function(palpate_check_layers)
  foreach(module IN LISTS PALPATE_ALL_MODULES)
    string(REPLACE "/" "_" name ${module})
    palpate_folder_of(${module} folder)
    file(GLOB files ${PROJECT_SOURCE_DIR}/${folder}/*.h ${PROJECT_SOURCE_DIR}/${folder}/*.cpp
      ${PROJECT_SOURCE_DIR}/${folder}/internal/*.h ${PROJECT_SOURCE_DIR}/${folder}/internal/*.cpp)
    foreach(file IN LISTS files)
      file(STRINGS ${file} includes REGEX "^#include \"(palpate|drivers|applications|tools)/")
      foreach(line IN LISTS includes)
        string(REGEX REPLACE "^#include \"(palpate/)?(.*)/[^/]*\".*" "\\2" used "${line}")
        if(used STREQUAL module OR used STREQUAL "${module}/internal")
          continue()
        endif()
        if(used MATCHES "^(.*)/internal$")
          message(FATAL_ERROR "layers: ${file}: ${line}: what lies in internal/ is for ${CMAKE_MATCH_1} alone")
        endif()
        string(REPLACE "/" "_" used_name "${used}")
        if(NOT DEFINED PALPATE_LAYER_OF_${used_name})
          message(FATAL_ERROR "layers: ${file}: ${line}: no module of that name in cmake/layers.cmake")
        endif()
        if(NOT PALPATE_LAYER_OF_${used_name} LESS PALPATE_LAYER_OF_${name})
          message(FATAL_ERROR "layers: ${file}: ${line}: ${module} (layer ${PALPATE_LAYER_OF_${name}}) may not "
            "include ${used} (layer ${PALPATE_LAYER_OF_${used_name}})")
        endif()
      endforeach()
      # palpate/server/physics holds palpate::server::physics, drivers/cameras palpate::drivers::cameras.
      file(STRINGS ${file} namespaces REGEX "^namespace palpate")
      if(namespaces)
        list(GET namespaces 0 line)
        string(REPLACE "/" "::" namespace "palpate::${module}")
        string(REGEX REPLACE "^namespace ([a-z0-9_: ]+) {.*" "\\1" said "${line}")
        string(REPLACE "::inline " "::" said "${said}")
        if(NOT "${said}" MATCHES "^${namespace}(::|$)")
          message(FATAL_ERROR "layers: ${file}: ${line}: namespace ${namespace} is expected, as the folder is named")
        endif()
      endif()
    endforeach()
  endforeach()
endfunction()
