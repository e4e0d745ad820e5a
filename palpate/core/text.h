// Words for messages. Text of a file or of a peer as a message may quote it: of a length a person reads, on
// one line and without what would steer a terminal, whatever it holds; and numbers of things.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace palpate::inline core {

// The character that a text in UTF-8 begins with.
struct Character {
  char32_t code = 0;
  std::size_t bytes = 1;  // its length; 1 where it is none
  bool valid = false;     // false: the first byte belongs to no character of UTF-8
};
Character first_character(std::string_view text);  // of one that is not empty

// What no line shows as a letter and what may steer the terminal that prints it: control characters (C0, DEL,
// C1), line and paragraph separators, characters that turn the direction of writing, and invisible ones.
bool is_control(char32_t code);
bool has_control(std::string_view text);  // bytes that are no UTF-8 are let pass
// True where a line may hold the text as it is: UTF-8 without a control character.
bool is_plain(std::string_view text);

// Control characters and bytes that are no UTF-8 become '?'; what is longer than `most` bytes is cut, between
// characters, and ends in "...".
std::string excerpt(std::string_view text, std::size_t most = 40);
// The same of all of it: what is about to be printed on a line of its own.
std::string one_line(std::string_view text);

// JSON in which control characters beyond those that JSON itself forbids are written as \uXXXX: what it says
// stays the same, and a terminal may show it.
std::string escaped_json(std::string_view json);

// "1 pose", "4 poses"; for nouns whose plural only adds an s.
inline std::string counted(std::size_t number, std::string_view noun) {
  return std::to_string(number) + ' ' + std::string(noun) + (number == 1 ? "" : "s");
}

}  // namespace palpate::inline core
