# Writes what the program says of its own making: which commit, which compiler. Run at each build; the file is touched
# only where something has changed.
#
#   cmake -DSOURCE=FOLDER -DTEMPLATE=FILE -DOUTPUT=FILE -DPALPATE_VERSION=... -DCOMPILER=... -DBUILD=... -P build_info.cmake

set(PALPATE_COMMIT "")
find_program(git git)
# Only of a clone of its own: an unpacked archive may lie within somebody else's.
if(git AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${git} --no-optional-locks describe --always --dirty --abbrev=8 --exclude * WORKING_DIRECTORY ${SOURCE}
    OUTPUT_VARIABLE PALPATE_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT PALPATE_COMMIT)
  file(READ ${SOURCE}/cmake/archived_commit.txt archived)
  if(archived MATCHES "^[0-9a-f]+")
    set(PALPATE_COMMIT ${CMAKE_MATCH_0})
  endif()
endif()
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
