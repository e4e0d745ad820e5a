// One matrix of a folder of text files.
#include "fuzz/check.h"
#include "palpate/device/pose_file.h"

namespace palpate::fuzz {

Refusals matrices(std::string_view file) {
  Refusals refusals;
  const auto pose = device::parse_matrix(file, "matrix.txt");
  if (answered(pose, refusals))
    hold(std::abs(pose->rotation.norm() - 1.0) < 1e-6 && pose->translation.allFinite(), "a pose is rigid");
  return refusals;
}

}  // namespace palpate::fuzz
