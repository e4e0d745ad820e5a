# The layers: a module may use modules of lower layers only. Configuring fails where a link, an #include or a
# namespace says otherwise. docs/architecture.md explains what lives where.
#
# A module's name is its folder without the `palpate/` in front: core is palpate/core, drivers/cameras is drivers/cameras.
# The applications that the program has, a folder each: one line here adds one to the layers, to the physics server and to
# the program's registry. None is fine, too. A folder gives `scene::ApplicationSpec specification()` in its
# specification.h (docs/guides/new-application.md).
set(PALPATE_APPLICATIONS
  applications/pingpong
  applications/touch
  applications/palpation)
if(NOT IS_DIRECTORY ${PROJECT_SOURCE_DIR}/applications)
  set(PALPATE_APPLICATIONS "")
endif()
# Further ones from outside this tree: folders .../applications/NAME, which may be included as "applications/NAME/...".
set(PALPATE_EXTRA_APPLICATIONS "" CACHE STRING "Folders of further applications, each called .../applications/NAME")
foreach(folder IN LISTS PALPATE_EXTRA_APPLICATIONS)
  if(NOT folder MATCHES "^/.*/(applications/([a-z][a-z0-9_]*))$" OR NOT EXISTS ${folder}/specification.h)
    message(FATAL_ERROR "PALPATE_EXTRA_APPLICATIONS: '${folder}': an absolute path .../applications/NAME of a folder that "
      "has a specification.h is expected, NAME in lower-case letters, digits and '_'")
  endif()
  set(module ${CMAKE_MATCH_1})
  string(REPLACE "/" "_" name ${module})
  set(PALPATE_FOLDER_OF_${name} ${folder})
  list(APPEND PALPATE_APPLICATIONS ${module})
endforeach()
set(PALPATE_LAYER_0 core)
set(PALPATE_LAYER_1 math time figures web)
set(PALPATE_LAYER_2 device record experiment)
set(PALPATE_LAYER_3 scene rig formats)
set(PALPATE_LAYER_4 physics calibration/noise transport render sim/config plugin)
set(PALPATE_LAYER_5 physics/deformable physics/tissue headset)
set(PALPATE_LAYER_6 physics/organ)
set(PALPATE_LAYER_7 calibration haptics drivers/network drivers/arms ${PALPATE_APPLICATIONS})
set(PALPATE_LAYER_8 record/session calibration/findings vision drivers/laboratory drivers/openigtlink drivers/vrpn drivers/ndi drivers/openhaptics drivers/haply drivers/forcedimension drivers/cameras)
set(PALPATE_LAYER_9 calibration/session calibration/forces server/physics server/graphics sim)
set(PALPATE_LAYER_10 desktop)
set(PALPATE_LAYER_11 evaluation)
set(PALPATE_LAYER_12 server/session evaluation/report)
set(PALPATE_LAYER_13 sim/lockstep evaluation/studies)
set(PALPATE_LAYER_14 tools/console tools/demo tools/doctor tools/manual)
set(PALPATE_LAYER_15 tools/commands)
set(PALPATE_LAYER_16 tools/program)
set(PALPATE_LAYER_COUNT 17)

# Where threads share memory: the thread sanitizer runs the tests of these for every change (target threaded_tests, label
# threaded), and those of all modules in scripts/long.
set(PALPATE_THREADED core time record transport)

# Where memory is at risk from what others send: the address sanitizer runs the tests of these for every change (target
# checked_tests, label checked), and those of all modules in scripts/long. Readers of files are fuzzed besides.
set(PALPATE_CHECKED transport)

# PALPATE_TEST_OPTIONS are the tests' own compiler options. Tests that compute much themselves are compiled as the program
# is all the same, and so are the loader's, which hold the program's libraries whole.
set(PALPATE_TESTS_AS_THE_PROGRAM plugin math device experiment calibration calibration/noise physics physics/deformable physics/tissue physics/organ haptics
  sim sim/lockstep vision render evaluation evaluation/studies applications/palpation)

# What a change need not wait for has one of two labels, and .ci/run leaves it to scripts/long. `long`: hundreds of repeats
# for statistics, long runs of what shorter tests run too; the sanitizers leave them out as well. `slow`: the other
# programs but a few, whose parts are tested one by one for every change, and comparisons with full solutions. For tests
# of GoogleTest a regular expression each; all programs are in tests/CMakeLists.txt.
set(PALPATE_LONG_PROGRAMS soak live_poses two_hosts forces_check palpation_by_mouse clocks calibrate_live three_doors trips session_window descriptors
  invariance weak_data world_values recorded_sessions recordings attacked_loops)
set(PALPATE_QUICK_PROGRAMS servers status console touch log chain_arm cartesian_arm forces tracker vrpn ndi plugins report examples documented_commands manual kept convert export
  foreign_files
  hostile_peers
  physics_alone no_application)
set(PALPATE_LONG_TESTS "Statistics\\." "TenMillionTicks" "FullSolution\\.")
set(PALPATE_SLOW_TESTS "^FewDescriptors\\." "^PreparedOrgan\\.Tick" "^Indentation\\.(ShallowPresses|TheTablesOf)" "^TipContact\\.(DrawnAside|WhatCannotSlip)"
  "^VerificationSession\\.AQuickLook" "^Materials/ForceReturn.*/(plain|softtissue)" "^Csv\\.RefusesWhatIsLarger" "^StereoPlay\\.BothEyes"
  "^SiteLaw\\.MeetsTheTables" "^BlockForces\\.ContrastBeside" "^Hand\\.(IsDrawnOverInATenth|WhoseElbow)" "^PixelHandEye\\.(StatesItsError|TenViewsOfLittle)"
  "^AnApplicationFromOutside\\.PlaysThroughTheExchange" "^PalpationByStaircase\\.ATraineeWhoFinds")

# PALPATE_PARTS=physics: the physics server alone, without code of tracker, camera and graphics, and without the
# libraries these need (OpenCV, OpenGL, EGL). A module that is not listed here cannot be linked there.
set(PALPATE_PHYSICS_PARTS core math time figures web experiment device record record/session scene rig physics physics/deformable physics/tissue physics/organ transport sim/config haptics drivers/laboratory drivers/arms drivers/openhaptics drivers/haply drivers/forcedimension
  ${PALPATE_APPLICATIONS} server/physics plugin tools/manual tools/commands tools/program)

set(PALPATE_ALL_MODULES "")
set(PALPATE_WHOLE_MODULES "")  # targets that a program holds whole for the plug-ins it loads (cmake/guests.cmake)
math(EXPR palpate_highest_layer "${PALPATE_LAYER_COUNT} - 1")
foreach(layer RANGE 0 ${palpate_highest_layer})
  foreach(module IN LISTS PALPATE_LAYER_${layer})
    list(APPEND PALPATE_ALL_MODULES ${module})
    string(REPLACE "/" "_" name ${module})
    if(NOT module MATCHES "^tools/")
      list(APPEND PALPATE_WHOLE_MODULES palpate_${name})
    endif()
    set(PALPATE_LAYER_OF_${name} ${layer})
  endforeach()
endforeach()
set_property(GLOBAL PROPERTY PALPATE_WHOLE_MODULES ${PALPATE_WHOLE_MODULES})

# The include path of a module's headers; also its folder, from the project's root, unless it comes from outside.
function(palpate_folder_of module result)
  if(NOT module MATCHES "^(drivers|applications|tools)(/|$)")
    string(PREPEND module "palpate/")
  endif()
  set(${result} ${module} PARENT_SCOPE)
endfunction()

# The folder of a module on this machine.
function(palpate_path_of module result)
  string(REPLACE "/" "_" name ${module})
  if(DEFINED PALPATE_FOLDER_OF_${name})
    set(${result} ${PALPATE_FOLDER_OF_${name}} PARENT_SCOPE)
  else()
    palpate_folder_of(${module} folder)
    set(${result} ${PROJECT_SOURCE_DIR}/${folder} PARENT_SCOPE)
  endif()
endfunction()

# palpate_module(DEPENDS core math ... LIBRARIES Eigen3::Eigen ...)
# Called in the CMakeLists.txt of a module's folder. Sources are the folder's *.cpp, tests its *_test.cpp; internal/ holds
# what no other module may include and what is not installed.
# DEPENDS names lower modules, TEST_DEPENDS those that only the tests need; LIBRARIES what comes from outside,
# TEST_LIBRARIES what only the tests need of that; SOURCES what lies elsewhere, EXCEPT files that are not built. The target is
# palpate_<name>, to others palpate::<name>.
function(palpate_module)
  cmake_parse_arguments(ARG "" "" "DEPENDS;TEST_DEPENDS;LIBRARIES;TEST_LIBRARIES;SOURCES;EXCEPT" ${ARGN})
  file(RELATIVE_PATH module ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  string(REGEX REPLACE "^palpate/" "" module ${module})
  if(CMAKE_CURRENT_SOURCE_DIR IN_LIST PALPATE_EXTRA_APPLICATIONS)
    string(REGEX REPLACE ".*/(applications/[^/]*)$" "\\1" module ${CMAKE_CURRENT_SOURCE_DIR})
  endif()
  string(REPLACE "/" "_" name ${module})
  set(target palpate_${name})
  file(GLOB sources CONFIGURE_DEPENDS *.cpp internal/*.cpp)
  file(GLOB tests CONFIGURE_DEPENDS *_test.cpp internal/*_test.cpp)
  if(tests)
    list(REMOVE_ITEM sources ${tests})
  endif()
  foreach(file IN LISTS ARG_EXCEPT)
    list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    list(REMOVE_ITEM tests ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  endforeach()
  palpate_leave_out_tests(tests applications_of_tests)
  list(REMOVE_ITEM applications_of_tests ${module})
  list(APPEND ARG_TEST_DEPENDS ${applications_of_tests})
  list(APPEND sources ${ARG_SOURCES})
  if(sources AND NOT PALPATE_LIBRARY)
    palpate_merge_sources(${target} sources)
  endif()
  if(sources)
    add_library(${target} STATIC ${sources})
    set(precompiled palpate_precompiled_modules)
    if(module IN_LIST PALPATE_PYTHON_MODULES)
      set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
      set(precompiled palpate_precompiled_independent)
    endif()
    if(TARGET ${precompiled})
      target_precompile_headers(${target} REUSE_FROM ${precompiled})
    endif()
    set(scope PUBLIC)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(palpate::${name} ALIAS ${target})
  # In this tree only: what is installed hands on no warnings, sanitizers or folders of ours.
  target_link_libraries(${target} ${scope} $<BUILD_INTERFACE:palpate_options>)
  target_compile_features(${target} ${scope} cxx_std_20)
  if(CMAKE_CURRENT_SOURCE_DIR IN_LIST PALPATE_EXTRA_APPLICATIONS)
    target_include_directories(${target} ${scope} $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/../..>)
  endif()
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
  if(PALPATE_SANITIZE MATCHES "thread" AND "opencv_core" IN_LIST ARG_LIBRARIES AND scope STREQUAL "PUBLIC")
    target_compile_options(${target} PRIVATE "SHELL:-include ${PROJECT_SOURCE_DIR}/cmake/opencv_in_one_thread.h")
  endif()
  if(PALPATE_TESTS AND tests)
    add_executable(${target}_test ${tests})
    target_link_libraries(${target}_test PRIVATE ${target} ${test_targets} ${ARG_TEST_LIBRARIES} GTest::gtest GTest::gtest_main)
    target_compile_definitions(${target}_test PRIVATE PALPATE_DATA_DIR="${PROJECT_SOURCE_DIR}/data")
    # Tests are compiled once and read the same headers of GoogleTest and the module.
    set_target_properties(${target}_test PROPERTIES UNITY_BUILD_BATCH_SIZE 16)
    set(precompiled palpate_precompiled_tests)
    if(PALPATE_TEST_OPTIONS AND module IN_LIST PALPATE_TESTS_AS_THE_PROGRAM)
      set(precompiled palpate_precompiled_modules)
    elseif(PALPATE_TEST_OPTIONS)
      target_compile_options(${target}_test PRIVATE ${PALPATE_TEST_OPTIONS})
      # Of an inline function that both have, the linker takes the first: not the tests', which may be far slower.
      if(sources)
        target_link_options(${target}_test PRIVATE "SHELL:-Wl,--whole-archive $<TARGET_FILE:${target}> -Wl,--no-whole-archive")
      endif()
    endif()
    if(TARGET ${precompiled})
      target_precompile_headers(${target}_test REUSE_FROM ${precompiled})
    endif()
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

# palpate_leave_out_tests(TESTS APPLICATIONS): a test may play one of this tree's applications. Takes tests of those that
# are not built out of the list TESTS; APPLICATIONS become the modules that the others need.
function(palpate_leave_out_tests tests_list modules_result)
  set(kept "")
  set(modules "")
  foreach(test IN LISTS ${tests_list})
    file(STRINGS ${test} includes REGEX "^#include \"applications/[^/\"]+/")
    list(TRANSFORM includes REPLACE "^#include \"(applications/[^/]+)/.*" "\\1")
    set(used ${includes})
    list(REMOVE_ITEM includes ${PALPATE_APPLICATIONS})
    if(NOT includes)
      list(APPEND kept ${test})
      list(APPEND modules ${used})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES modules)
  set(${tests_list} "${kept}" PARENT_SCOPE)
  set(${modules_result} "${modules}" PARENT_SCOPE)
endfunction()

# palpate_discover_tests(target LABELS ... RESOURCE_LOCK name): the GoogleTest tests of a program, each with these labels,
# and with `long` or `slow` where a list above names it. With PALPATE_TESTS_TOGETHER one test of ctest, without those.
function(palpate_discover_tests target)
  cmake_parse_arguments(ARG "" "RESOURCE_LOCK" "LABELS" ${ARGN})
  list(JOIN PALPATE_LONG_TESTS "|" long)
  list(JOIN PALPATE_SLOW_TESTS "|" slow)
  if(PALPATE_TESTS_TOGETHER)
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    add_test(NAME ${target} COMMAND ${CMAKE_COMMAND} -E env PYTHONDONTWRITEBYTECODE=1 ${Python3_EXECUTABLE}
      ${PROJECT_SOURCE_DIR}/tests/run_together.py $<TARGET_FILE:${target}> "${long}|${slow}")
    set_tests_properties(${target} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT 900)
    if(ARG_RESOURCE_LOCK)
      set_tests_properties(${target} PROPERTIES RESOURCE_LOCK ${ARG_RESOURCE_LOCK})
    endif()
    return()
  endif()
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST TEST_LIST ${target}_found PROPERTIES TIMEOUT 300
    ENVIRONMENT "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/cmake/tsan.supp")
  # Which tests there are is known when ctest starts: it reads this after it has asked the program.
  set(settings ${CMAKE_CURRENT_BINARY_DIR}/${target}_labels.cmake)
  if(ARG_RESOURCE_LOCK)
    set(lock "RESOURCE_LOCK ${ARG_RESOURCE_LOCK}")
  endif()
  file(CONFIGURE OUTPUT ${settings} @ONLY CONTENT [[
foreach(test IN LISTS @target@_found)
  set(labels "@ARG_LABELS@")
  if(test MATCHES [==[@long@]==])
    list(APPEND labels long)
  elseif(test MATCHES [==[@slow@]==])
    list(APPEND labels slow)
  endif()
  set_tests_properties("${test}" PROPERTIES LABELS "${labels}" @lock@)
  if(labels MATCHES "(^|;)(long|slow)(;|\$)")
    set_tests_properties("${test}" PROPERTIES TIMEOUT 900)
  endif()
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
  set(folders tests)
  if(PALPATE_LIBRARY)
    list(APPEND folders examples fuzz)
  endif()
  if(PALPATE_PYTHON_MODULES)
    list(PREPEND folders python)
  endif()
  if("${PALPATE_PARTS}" STREQUAL "physics")
    set(modules ${PALPATE_PHYSICS_PARTS})
    set(folders tests)
  elseif(NOT "${PALPATE_PARTS}" MATCHES "^(all)?$")
    message(FATAL_ERROR "PALPATE_PARTS is '${PALPATE_PARTS}'; all or physics is expected")
  endif()
  foreach(module IN LISTS modules)
    palpate_path_of(${module} folder)
    if(EXISTS ${folder}/CMakeLists.txt)
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
    palpate_path_of(${module} folder)
    file(GLOB files ${folder}/*.h ${folder}/*.cpp ${folder}/internal/*.h ${folder}/internal/*.cpp)
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
        if(file MATCHES "_test\\.cpp$" AND used MATCHES "^applications/[^/]+$" AND NOT used IN_LIST PALPATE_APPLICATIONS)
          continue()  # palpate_leave_out_tests
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
