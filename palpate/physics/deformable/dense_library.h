// Which dense algebra (BLAS) stands behind the sparse solver, and behind OpenCV in the same process. Any thread.
#pragma once

#include <string>

namespace palpate::physics::deformable {

struct DenseLibrary {
  std::string name;        // its file; empty where that is not known
  bool in_threads = true;  // may be called by several threads at once; false: it answers wrongly then
};

DenseLibrary dense_library();

}  // namespace palpate::physics::deformable
