#include "palpate/core/internal/toml_check.h"

#include <algorithm>

#include "palpate/core/file.h"

namespace palpate::inline core {
namespace {

constexpr int kMostDots = 32;        // of one key; ours have 1
constexpr int kMostNested = 32;      // lists and tables in brackets; ours have 3
constexpr int kMostTables = 20'000;  // an application's settings have tens, a rig's landmarks hundreds

// Where the text in quotes that begins at `at` is over: as the parser sees it, or earlier where the parser
// finds it broken.
std::size_t after_quotes(std::string_view content, std::size_t at) {
  const char quote = content[at];
  const bool escapes = quote == '"';
  const std::string three(3, quote);
  const bool many_lines = content.substr(at, 3) == three;
  at += many_lines ? 3 : 1;
  while (at < content.size()) {
    if (escapes && content[at] == '\\') {
      at += 2;
    } else if (many_lines && content.substr(at, 3) == three) {
      at += 3;
      for (int i = 0; i < 2 && at < content.size() && content[at] == quote; ++i) ++at;  // the text's own
      return at;
    } else if (!many_lines && (content[at] == quote || content[at] == '\n')) {
      return content[at] == quote ? at + 1 : at;
    } else {
      ++at;
    }
  }
  return content.size();
}

// Counts along a file what the parser would build of it.
class TomlCounts {
 public:
  // A character outside quotes and comments. What is too much of it; nullptr: nothing.
  const char* take(char c) {
    switch (c) {
      case '\0':
        return "holds a zero byte; a text file is expected";
      case '.':
        return ++dots_ > kMostDots ? "has a key of more than 33 parts; at most a few are expected" : nullptr;
      case '=':
        if (dots_ > 0) ++tables_;
        break;
      case '[':
      case '{':
        if (c == '[' && line_begins_) ++tables_;
        if (++nested_ > kMostNested) return "has more than 32 brackets in each other; at most 3 are expected";
        break;
      case ']':
      case '}':
        nested_ = std::max(0, nested_ - 1);
        break;
      case ',':
      case '\n':
      case '\r':
        break;
      default:
        line_begins_ = line_begins_ && (c == ' ' || c == '\t');
        return nullptr;
    }
    dots_ = 0;
    line_begins_ = c == '\n';
    return tables_ > kMostTables ? "has more than 20000 tables; at most some hundred are expected" : nullptr;
  }
  void take_quotes() { line_begins_ = false; }

 private:
  int dots_ = 0;  // of the key, or of the number, that is going on
  int nested_ = 0, tables_ = 0;
  bool line_begins_ = true;
};

}  // namespace

Expected<void> check_toml(std::string_view content, const std::string& source) {
  if (content.size() > kMostSettingsBytes)
    return wrong_use("{}: holds {} bytes; a TOML file of at most {} is expected", source, content.size(),
                     kMostSettingsBytes);
  TomlCounts counts;
  int line = 1;
  std::size_t at = 0;
  while (at < content.size()) {
    const char c = content[at];
    if (c == '"' || c == '\'') {
      const std::size_t end = std::min(after_quotes(content, at), content.size());
      line += static_cast<int>(std::count(content.begin() + static_cast<std::ptrdiff_t>(at),
                                          content.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      counts.take_quotes();
      at = end;
    } else if (c == '#') {
      at = std::min(content.find_first_of("\r\n", at), content.size());
    } else {
      if (const char* refusal = counts.take(c)) return wrong_use("{}:{}: {}", source, line, refusal);
      if (c == '\n') ++line;
      ++at;
    }
  }
  return {};
}

}  // namespace palpate::inline core
