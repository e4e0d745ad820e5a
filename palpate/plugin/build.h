// How the code that includes this was compiled, as far as two binaries have to agree on it who share C++ types. All
// macros: a function in a plug-in would be the program's own, by the linker's rules, and always agree.
//
// NDEBUG is not among it: no type of Palpate, Eigen, fmt or the standard library lies differently without assertions.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "palpate/plugin/guests.h"
#include "palpate/plugin/release.h"

#define PALPATE_TEXT_OF_(x) #x
#define PALPATE_TEXT_OF(x) PALPATE_TEXT_OF_(x)

#if defined(__clang__)
#define PALPATE_COMPILER "clang " PALPATE_TEXT_OF(__clang_major__)
#elif defined(__GNUC__)
#define PALPATE_COMPILER "gcc " PALPATE_TEXT_OF(__GNUC__)
#else
#define PALPATE_COMPILER "another compiler"
#endif

#if defined(_LIBCPP_VERSION)
#define PALPATE_STANDARD_LIBRARY "libc++ " PALPATE_TEXT_OF(_LIBCPP_VERSION)
#elif defined(_GLIBCXX_DEBUG)
#define PALPATE_STANDARD_LIBRARY "libstdc++ " PALPATE_TEXT_OF(_GLIBCXX_RELEASE) " in debug mode"
#elif defined(_GLIBCXX_RELEASE)
#define PALPATE_STANDARD_LIBRARY \
  "libstdc++ " PALPATE_TEXT_OF(_GLIBCXX_RELEASE) " abi " PALPATE_TEXT_OF(_GLIBCXX_USE_CXX11_ABI)
#else
#define PALPATE_STANDARD_LIBRARY "another standard library"
#endif

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define PALPATE_SANITIZER "address"
#elif __has_feature(thread_sanitizer)
#define PALPATE_SANITIZER "thread"
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define PALPATE_SANITIZER "address"
#elif defined(__SANITIZE_THREAD__)
#define PALPATE_SANITIZER "thread"
#endif
#ifndef PALPATE_SANITIZER
#define PALPATE_SANITIZER "none"
#endif

#define PALPATE_BUILD_OPTIONS \
  PALPATE_STANDARD_LIBRARY ", Eigen " PALPATE_TEXT_OF(EIGEN_WORLD_VERSION) "." PALPATE_TEXT_OF(               \
      EIGEN_MAJOR_VERSION) "." PALPATE_TEXT_OF(EIGEN_MINOR_VERSION) " aligned to " PALPATE_TEXT_OF(           \
      EIGEN_MAX_ALIGN_BYTES) " bytes, sanitizer " PALPATE_SANITIZER

// Sizes of the types that guests fill: seen where two trees are called by one release.
#define PALPATE_LAYOUT                                                          \
  {                                                                             \
    static_cast<std::uint32_t>(sizeof(::palpate::scene::ApplicationSpec)),      \
        static_cast<std::uint32_t>(sizeof(::palpate::scene::SceneDescription)), \
        static_cast<std::uint32_t>(sizeof(::palpate::scene::SceneState)),       \
        static_cast<std::uint32_t>(sizeof(::palpate::device::Driver))           \
  }
