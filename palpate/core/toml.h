// TOML files read strictly: every complaint names file, line and key, and a key nobody asked for is one of
// them.
//
// Ask a table for everything it may hold, then call finish() once on the root. The first complaint wins;
// after it the readers return harmless defaults, so that a reader function needs no checks between its lines:
//
//   auto file = read_toml(path);
//   if (!file) return tl::unexpected(file.error());
//   const double rate = file->number("rate_hz", {.low = 1.0, .high = 1e5});
//   const auto camera = file->table("camera").number_or("fx", 560.0, kPositive);
//   if (const auto done = file->finish(); !done) return tl::unexpected(done.error());
//
// Tables are light handles on one document: copy them freely, use them from one thread. A handle of an absent
// table is valid, `exists()` is false, and its required keys complain. Errors: wrong use.
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::inline core {

// What a number may be; both ends included. NaN and infinity are never accepted.
struct NumberRange {
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
};
inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kNotNegative{0.0, std::numeric_limits<double>::max()};
inline constexpr NumberRange kPositive{std::numeric_limits<double>::min(),
                                       std::numeric_limits<double>::max()};

class TomlTable {
 public:
  bool exists() const;
  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;  // in alphabetical order
  int line() const;                       // where the table begins, 0 where unknown

  double number(std::string_view key, NumberRange range = {}) const;
  double number_or(std::string_view key, double fallback, NumberRange range = {}) const;
  long long integer(std::string_view key, NumberRange range = {}) const;
  long long integer_or(std::string_view key, long long fallback, NumberRange range = {}) const;
  bool flag(std::string_view key) const;
  bool flag_or(std::string_view key, bool fallback) const;
  std::string text(std::string_view key) const;
  std::string text_or(std::string_view key, std::string fallback) const;
  std::vector<std::string> texts(std::string_view key) const;  // none where the key is absent
  // One of `allowed`; the complaint lists them.
  std::string choice(std::string_view key, const std::vector<std::string>& allowed) const;

  // A list of exactly `count` numbers (any number of them where count is 0).
  std::vector<double> numbers(std::string_view key, std::size_t count, NumberRange range = {}) const;
  template <std::size_t N>
  std::array<double, N> numbers(std::string_view key, NumberRange range = {}) const {
    const auto list = numbers(key, N, range);
    std::array<double, N> result{};
    for (std::size_t i = 0; i < N; ++i) result[i] = list[i];
    return result;
  }
  template <std::size_t N>
  std::array<double, N> numbers_or(std::string_view key, const std::array<double, N>& fallback,
                                   NumberRange range = {}) const {
    return has(key) ? numbers<N>(key, range) : (expect(key), fallback);
  }
  // A list of lists of `width` numbers each, such as corners = [[x, y, z], ...]; `count` of them, any number
  // where 0.
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t width, std::size_t count = 0,
                                        NumberRange range = {}) const;

  TomlTable table(std::string_view key) const;                // [key]; may be absent
  std::vector<TomlTable> tables(std::string_view key) const;  // [[key]]; none where absent

  // A complaint of the caller's own about a key of this table: "FILE:LINE: KEY: message".
  void complain(std::string_view key, std::string_view message) const;
  // Says that the key is known, without reading it (it counts as used where it is there).
  void expect(std::string_view key) const;

  // The first complaint, if any; else the first key nobody asked for, if any. Covers the whole document.
  Expected<void> finish() const;

 private:
  struct Document;
  friend Expected<TomlTable> parse_toml(std::string_view content, std::string source);
  TomlTable(std::shared_ptr<Document> document, const void* table, std::string path);
  const void* wanted(std::string_view key, std::string_view kind, bool required) const;
  const void* wanted_list(std::string_view key, std::size_t count, std::string_view expected) const;
  double number_of(const void* node, std::string_view key, NumberRange range) const;

  std::shared_ptr<Document> document_;
  const void* table_ = nullptr;  // toml::table, null where absent
  std::string path_;             // "camera.", for messages
};

Expected<TomlTable> parse_toml(std::string_view content, std::string source);
Expected<TomlTable> read_toml(const std::filesystem::path& path);

// A number as TOML writes it, with all the digits that reading it back needs; `toml_quoted` escapes a text.
std::string toml_number(double value);
std::string toml_quoted(std::string_view text);

}  // namespace palpate::inline core
