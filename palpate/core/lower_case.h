// Letters of ASCII as small ones: for names that people write in either way.
#pragma once

#include <string>
#include <string_view>

namespace palpate::inline core {

inline std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

}  // namespace palpate::inline core
