// Two files in one: what stands before and after the line "=====".
#pragma once

#include <string_view>
#include <utility>

namespace palpate::fuzz {

inline std::pair<std::string_view, std::string_view> split_files(std::string_view both) {
  constexpr std::string_view kBetween = "\n=====\n";
  const auto at = both.find(kBetween);
  if (at == std::string_view::npos) return {both, both};
  return {both.substr(0, at + 1), both.substr(at + kBetween.size())};
}

}  // namespace palpate::fuzz
