// Words for messages. Text of a file as a message may quote it: of a length a person reads, and on one line
// whatever it holds; and numbers of things.
#pragma once

#include <string>
#include <string_view>

namespace palpate::inline core {

// Control characters become '?'; what is longer than `most` bytes is cut, between characters, and ends in
// "...".
inline std::string excerpt(std::string_view text, std::size_t most = 40) {
  std::size_t length = text.size();
  if (length > most) {
    length = most;
    while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80) --length;  // UTF-8
  }
  std::string shown(text.substr(0, length));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) == 127) c = '?';
  return length < text.size() ? shown + "..." : shown;
}

// "1 pose", "4 poses"; for nouns whose plural only adds an s.
inline std::string counted(std::size_t number, std::string_view noun) {
  return std::to_string(number) + ' ' + std::string(noun) + (number == 1 ? "" : "s");
}

}  // namespace palpate::inline core
