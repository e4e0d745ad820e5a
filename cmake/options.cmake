# Warnings, sanitizers and the language settings every target shares, carried by one interface target.
add_library(palpate_options INTERFACE)
target_include_directories(palpate_options INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/generated)
target_compile_options(palpate_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
  -Woverloaded-virtual -Wno-missing-field-initializers)
if(PALPATE_WERROR)
  target_compile_options(palpate_options INTERFACE -Werror)
endif()
# GCC 12 reports array bounds and uninitialised values inside Eigen's own vectorised code; both are known
# false alarms of that compiler version, and stay visible as warnings of newer ones.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(palpate_options INTERFACE -Wno-maybe-uninitialized -Wno-array-bounds
    -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict)
endif()
# Results must be the same on every run and build: no fused operations chosen by the optimiser's mood.
target_compile_options(palpate_options INTERFACE -ffp-contract=off)
# GCC collects its garbage often, by what it thinks of the machine's memory; a tenth of its time. A translation unit stays
# below the 1.5 GB that scripts/build.sh counts with.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(palpate_options INTERFACE "SHELL:--param ggc-min-expand=1000" "SHELL:--param ggc-min-heapsize=1000000")
endif()
# What some libraries ask for is asked for everywhere: precompiled headers are those of all modules.
target_compile_options(palpate_options INTERFACE -pthread)
if(PALPATE_SANITIZE MATCHES thread)
  # GCC's thread sanitizer knows no fences and says so; each of Asio's contexts is run by one thread here, so none is needed.
  target_compile_definitions(palpate_options INTERFACE BOOST_ASIO_DISABLE_FENCED_BLOCK)
endif()
if(PALPATE_SANITIZE)
  # Without the checks of each pointer for null, alignment and size: in Eigen's templates they are half of all
  # compiler time, a null pointer stops under the address sanitizer too, and Eigen asserts its alignment.
  target_compile_options(palpate_options INTERFACE -fsanitize=${PALPATE_SANITIZE}
    -fno-sanitize=null,alignment,object-size -fno-omit-frame-pointer)
  # A library that is loaded at run time through our own declarations (drivers/openhaptics) has the same binary
  # interface and, to clang, other types.
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    target_compile_options(palpate_options INTERFACE -fno-sanitize=function)
  endif()
  target_link_options(palpate_options INTERFACE -fsanitize=${PALPATE_SANITIZE})
endif()
