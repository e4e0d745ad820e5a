// Lines, words and numbers of the text mesh formats, and numbers of the binary ones. For the parsers of
// mesh_file.h only.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace palpate::scene::mesh_text {

// Goes through a text line by line; either end of line, a last line without one.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const auto end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }  // of the line that next() gave, from 1
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

// Takes the next word off the front; empty at the end.
inline std::string_view word(std::string_view& line) {
  const auto begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  line.remove_prefix(begin);
  const auto end = std::min(line.find_first_of(" \t"), line.size());
  const auto found = line.substr(0, end);
  line.remove_prefix(end);
  return found;
}

template <typename Number>
std::optional<Number> number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace palpate::scene::mesh_text
