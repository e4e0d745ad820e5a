# Files that travel inside a library: palpate_embed(RESULT FUNCTION palpate::module::files FILES ...) sets RESULT to a
# source for palpate_module(... SOURCES ${RESULT}). It defines `palpate::figures::PageFiles files()` in that namespace, each
# file under its name without its folder. The assembler copies the bytes into the read-only data.
function(palpate_embed result)
  cmake_parse_arguments(ARG "" "FUNCTION" "FILES" ${ARGN})
  string(REGEX MATCH "^(.*)::([a-z_]+)$" matched ${ARG_FUNCTION})
  set(PALPATE_EMBED_NAMESPACE ${CMAKE_MATCH_1})
  set(PALPATE_EMBED_FUNCTION ${CMAKE_MATCH_2})
  string(MAKE_C_IDENTIFIER ${ARG_FUNCTION} prefix)
  set(PALPATE_EMBED_FILES "")
  set(PALPATE_EMBED_LIST "")
  set(number 0)
  foreach(file IN LISTS ARG_FILES)
    get_filename_component(name ${file} NAME)
    set(symbol ${prefix}_${number})
    math(EXPR number "${number} + 1")
    string(APPEND PALPATE_EMBED_FILES "PALPATE_EMBED(${symbol}, \"${file}\")\n")
    string(APPEND PALPATE_EMBED_LIST "          {\"${name}\", {${symbol}, ${symbol}_end}},\n")
  endforeach()
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${prefix}.cpp)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/embedded.cpp.in ${source} @ONLY)
  # Link-time optimisation does not see what the assembler defines; the compiler does not see the files as dependencies.
  set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS -fno-lto SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON
    OBJECT_DEPENDS "${ARG_FILES}")
  set(${result} ${source} PARENT_SCOPE)
endfunction()
