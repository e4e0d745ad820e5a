# The program alone, in few translation units that hold several modules each (docs/decisions/0005): what
# PALPATE_LIBRARY=OFF builds. The modules remain as targets that say what they include and link, without code.

# Sources of a module that a merged unit includes; the rest (generated files) stays in the list.
function(palpate_merge_sources target sources_list)
  set(kept "")
  foreach(source IN LISTS ${sources_list})
    string(FIND ${source} ${CMAKE_CURRENT_BINARY_DIR}/ generated)
    if(generated EQUAL 0)
      list(APPEND kept ${source})
    else()
      set_property(GLOBAL APPEND PROPERTY PALPATE_MERGED_SOURCES ${source})
    endif()
  endforeach()
  set_property(GLOBAL APPEND PROPERTY PALPATE_MERGED_MODULES ${target})
  # An archive needs a file.
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/merged/empty.cpp CONTENT "")
  set(${sources_list} ${kept} ${PROJECT_BINARY_DIR}/merged/empty.cpp PARENT_SCOPE)
endfunction()

# palpate_merge_into(TARGET SOURCE ...): its sources are units of about this many bytes, of the modules so far in their
# layers' order and of SOURCE. A unit takes GCC 12 up to 3 GB, which scripts/build.sh counts with.
set(PALPATE_MERGED_BYTES 300000)
function(palpate_merge_into target)
  get_property(sources GLOBAL PROPERTY PALPATE_MERGED_SOURCES)
  get_property(modules GLOBAL PROPERTY PALPATE_MERGED_MODULES)
  set(bytes 0)
  set(number 0)
  set(content "")
  foreach(source IN LISTS sources ARGN)
    file(SIZE ${source} size)
    math(EXPR bytes "${bytes} + ${size}")
    string(APPEND content "#include \"${source}\"\n")
    if(bytes GREATER PALPATE_MERGED_BYTES)
      palpate_write_unit(${target} ${number} "${content}")
      math(EXPR number "${number} + 1")
      set(bytes 0)
      set(content "")
    endif()
  endforeach()
  palpate_write_unit(${target} ${number} "${content}")
  foreach(module IN LISTS modules)
    # Not ours: named as a system's they would be spared warnings.
    target_include_directories(${target} SYSTEM PRIVATE
      "$<FILTER:$<TARGET_PROPERTY:${module},INCLUDE_DIRECTORIES>,EXCLUDE,^${PROJECT_SOURCE_DIR}$|/generated$>")
    target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:${module},COMPILE_DEFINITIONS>)
  endforeach()
  # What the modules have named already, CMake does not take from palpate_options a second time.
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
  set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
endfunction()

function(palpate_write_unit target number content)
  set(unit ${PROJECT_BINARY_DIR}/merged/unit_${number}.cpp)
  file(CONFIGURE OUTPUT ${unit} CONTENT "${content}" @ONLY)
  target_sources(${target} PRIVATE ${unit})
endfunction()
