#include "palpate/physics/deformable/dense_library.h"

#include <dlfcn.h>
#include <fmt/core.h>

namespace palpate::physics::deformable {
namespace {

template <typename Function>
Function* function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

DenseLibrary dense_library() {
  if (auto* version = function<const char*()>("bli_info_get_version_str"))
    return {fmt::format("BLIS {}", version()), true};
  if (auto* parallel = function<int()>("openblas_get_parallel")) {
    constexpr int kWithoutThreads = 0;  // and then without the locks that other people's threads need
    return {parallel() == kWithoutThreads ? "OpenBLAS without threads" : "OpenBLAS",
            parallel() != kWithoutThreads};
  }
  return {"one that does not tell its name", true};
}

}  // namespace palpate::physics::deformable
