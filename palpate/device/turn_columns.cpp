#include "palpate/device/turn_columns.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "palpate/core/lower_case.h"
#include "palpate/core/text.h"

namespace palpate::device {
namespace {

// Without what stands before and behind it: "marker_roll_deg", "Yaw [rad]".
bool tells_turn(std::string_view name) {
  constexpr std::array kWords = {"roll",  "pitch", "yaw",   "rx",   "ry",       "rz",   "rot_x", "rot_y",
                                 "rot_z", "euler", "orien", "quat", "rotation", "rvec", "q0",    "q1",
                                 "q2",    "q3",    "qw",    "qx",   "qy",       "qz",   "q_w",   "q_x",
                                 "q_y",   "q_z",   "r_x",   "r_y",  "r_z"};
  const std::string lower = lower_case(name);
  return std::any_of(kWords.begin(), kWords.end(), [&](std::string_view word) {
    for (auto at = lower.find(word); at != std::string::npos; at = lower.find(word, at + 1)) {
      const auto end = at + word.size();
      const auto letter = [&](std::size_t i) {
        return i < lower.size() && lower[i] >= 'a' && lower[i] <= 'z';
      };
      const bool begins = at == 0 || !letter(at - 1);
      const bool ends = !letter(end) || word == "orien" || word == "quat" || word == "euler";
      if (begins && ends) return true;
    }
    return false;
  });
}

}  // namespace

std::string turn_columns(std::span<const std::string> header) {
  std::string names;
  for (const auto& name : header)
    if (tells_turn(name)) names += (names.empty() ? "" : ",") + excerpt(name, 24);
  return excerpt(names, 120);
}

}  // namespace palpate::device
