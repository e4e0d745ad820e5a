# Programs and plug-ins made of Palpate's modules: in this tree, and installed for others (docs/guides/library.md).

# palpate_takes_plugins(TARGET): the program holds every module whole and shows their names, so that the plug-ins it
# loads use its one copy of each, also of what it does not call itself.
function(palpate_takes_plugins target)
  get_property(modules GLOBAL PROPERTY PALPATE_WHOLE_MODULES)
  set(whole "")
  foreach(module IN LISTS modules)
    if(TARGET ${module})
      get_target_property(type ${module} TYPE)
      if(type STREQUAL "STATIC_LIBRARY")
        list(APPEND whole ${module})
      endif()
    endif()
  endforeach()
  list(JOIN whole "," whole)
  set_target_properties(${target} PROPERTIES ENABLE_EXPORTS ON LINK_LIBRARY_OVERRIDE "WHOLE_ARCHIVE,${whole}")
endfunction()

# palpate_add_program(NAME SOURCE ...): a program with all of Palpate's commands and guests of its own
# (tools/commands/program.h).
function(palpate_add_program name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE palpate::tools_commands)
  palpate_takes_plugins(${name})
endfunction()

# palpate_add_plugin(NAME SOURCE ...): NAME.so, which a program loads (palpate/plugin/plugin.h). It has the headers and
# is linked with no module: the program that loads it brings them.
function(palpate_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  target_include_directories(${name} SYSTEM PRIVATE $<TARGET_PROPERTY:palpate::plugin,INTERFACE_INCLUDE_DIRECTORIES>)
  target_compile_definitions(${name} PRIVATE $<TARGET_PROPERTY:palpate::plugin,INTERFACE_COMPILE_DEFINITIONS>)
  target_compile_features(${name} PRIVATE cxx_std_20)
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_EXTENSIONS OFF)
endfunction()
