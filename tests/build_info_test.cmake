# A tiny clone, an archive of it and a copy without either: what a build of each says of its commit.
# cmake -DROOT=<project> -DSCRATCH=<empty folder> -P build_info_test.cmake
find_program(GIT git REQUIRED)
file(REMOVE_RECURSE ${SCRATCH})
set(clone ${SCRATCH}/clone)
file(MAKE_DIRECTORY ${clone}/cmake)
foreach(name .gitattributes cmake/archived_commit.txt)
  configure_file(${ROOT}/${name} ${clone}/${name} COPYONLY)
endforeach()

function(git folder)
  execute_process(COMMAND ${GIT} -c user.name=a -c user.email=a@b ${ARGN} WORKING_DIRECTORY ${folder} OUTPUT_VARIABLE output
    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  set(output "${output}" PARENT_SCOPE)
endfunction()

# The commit that a build of this folder states is this one.
function(states folder expected)
  file(WRITE ${SCRATCH}/template "@PALPATE_COMMIT@ of @PALPATE_VERSION@ by @COMPILER@")
  execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE=${folder} -DTEMPLATE=${SCRATCH}/template -DOUTPUT=${SCRATCH}/output
    -DPALPATE_VERSION=1.2 "-DCOMPILER=Any 3" -P ${ROOT}/cmake/build_info.cmake COMMAND_ERROR_IS_FATAL ANY)
  file(STRINGS ${SCRATCH}/output stated)
  if(NOT stated STREQUAL "${expected} of 1.2 by Any 3")
    message(FATAL_ERROR "${folder}: '${stated}', and '${expected} of 1.2 by Any 3' is expected")
  endif()
endfunction()

git(${clone} init --quiet)
git(${clone} add -A)
git(${clone} commit --quiet -m first)
git(${clone} tag v9)
git(${clone} rev-parse --short=8 HEAD)
set(commit ${output})
states(${clone} ${commit})

# Nothing new, nothing written: else the program would be linked again at each build.
file(TIMESTAMP ${SCRATCH}/output before "%s %f")
execute_process(COMMAND ${CMAKE_COMMAND} -E sleep 0.01)
states(${clone} ${commit})
file(TIMESTAMP ${SCRATCH}/output after "%s %f")
if(NOT before STREQUAL after)
  message(FATAL_ERROR "the file was written again, although nothing had changed")
endif()

git(${clone} archive --output=${SCRATCH}/archive.tar HEAD)
file(ARCHIVE_EXTRACT INPUT ${SCRATCH}/archive.tar DESTINATION ${clone}/unpacked)
git(${clone} rev-parse --short HEAD)
states(${clone}/unpacked ${output})  # within another's clone, whose commit is not its own

file(APPEND ${clone}/cmake/archived_commit.txt "more\n")
states(${clone} ${commit}-dirty)

file(COPY ${clone}/cmake DESTINATION ${SCRATCH}/copy)
states(${SCRATCH}/copy "")
