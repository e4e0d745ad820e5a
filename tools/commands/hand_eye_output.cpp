#include "tools/commands/hand_eye_output.h"

#include <utility>

#include "palpate/core/file.h"
#include "tools/commands/files_of_others.h"

namespace palpate::tools::commands {

Expected<PosePair> read_pose_pair(const std::string& hand, const std::string& eye,
                                  const std::string& expected) {
  auto first = read_poses(hand);
  if (!first) return tl::unexpected(first.error());
  auto second = read_poses(eye);
  if (!second) return tl::unexpected(second.error());
  if (first->hash == second->hash)
    return wrong_use("{}: holds the same as {}; {} are expected", eye, hand, expected);
  std::string hash = content_hash(first->hash + second->hash);
  return PosePair{std::move(*first), std::move(*second), std::move(hash)};
}

}  // namespace palpate::tools::commands
