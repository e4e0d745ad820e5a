#include "palpate/physics/deformable/dense_library.h"

#include <dlfcn.h>

#include <filesystem>

namespace palpate::physics::deformable {
DenseLibrary dense_library() {
  DenseLibrary found;
  Dl_info from{};
  if (void* multiply = dlsym(RTLD_DEFAULT, "dgemm_"); multiply && dladdr(multiply, &from) != 0) {
    std::error_code unknown;
    const auto file = std::filesystem::canonical(from.dli_fname, unknown);
    found.name = unknown ? from.dli_fname : file.string();
  }
  constexpr int kWithoutThreads = 0;  // and then without the locks that other people's threads need
  if (auto* parallel = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_parallel")))
    found.in_threads = parallel() != kWithoutThreads;
  return found;
}

}  // namespace palpate::physics::deformable
