// What is told of the BLAS in this process. This program itself answers as an OpenBLAS does that is asked for its threads.
#include "palpate/physics/deformable/dense_library.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace palpate::physics::deformable {
namespace {

int threads_of_openblas = 0;

}  // namespace

// Found before that of any library, for the program shows its names (CMakeLists.txt).
extern "C" int openblas_get_parallel() { return threads_of_openblas; }

namespace {

TEST(DenseLibrary, IsTheFileThatHoldsTheProductOfMatricesThatIsCalled) {
  const std::filesystem::path file = dense_library().name;
  ASSERT_TRUE(file.is_absolute()) << file;
  EXPECT_EQ(file, std::filesystem::canonical(file));
  void* library = dlopen(file.c_str(), RTLD_LAZY | RTLD_NOLOAD);
  ASSERT_NE(library, nullptr) << file << " is not loaded";
  EXPECT_EQ(dlsym(library, "dgemm_"), dlsym(RTLD_DEFAULT, "dgemm_"));
  dlclose(library);
}

TEST(DenseLibrary, OpenBlasWithoutThreadsMayNotBeCalledByTwoAtOnce) {
  for (const int threads : {0, 1, 2}) {  // none, its own, OpenMP's
    threads_of_openblas = threads;
    EXPECT_EQ(dense_library().in_threads, threads > 0) << threads;
  }
}

}  // namespace
}  // namespace palpate::physics::deformable
