#include "tools/commands/hand_eye_output.h"

#include <fmt/format.h>

#include <cmath>
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

std::string warning_of_clocks(double delay_s) {
  if (std::abs(delay_s) <= rig::kLongestDelay) return "";
  return fmt::format(
      "the stamps of hand and eye are {:.6g} s apart: their clocks have different origins, or the recordings "
      "are of different motions; a rig does not take this delay over, for in use one clock stamps both",
      std::abs(delay_s));
}

void set_camera_delay(rig::Rig& rig, double delay_s, double std_s, const rig::Provenance& from) {
  if (std::abs(delay_s) > rig::kLongestDelay) return;
  if (!rig.delays) rig.delays.emplace();
  rig.delays->camera_after_tracker_s = -delay_s;
  rig.delays->camera_std_s = std_s;
  rig.delays->from = from;
}

}  // namespace palpate::tools::commands
