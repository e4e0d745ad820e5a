// Which hand of the person holds the stylus and is seen there by the camera. A value, and its word in files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::device {

enum class HoldingHand : std::uint8_t { none, right, left };

inline std::vector<std::string> holding_hand_words() { return {"none", "right", "left"}; }
// Of another word: none.
inline HoldingHand holding_hand_of(std::string_view word) {
  return word == "right" ? HoldingHand::right : word == "left" ? HoldingHand::left : HoldingHand::none;
}

}  // namespace palpate::device
