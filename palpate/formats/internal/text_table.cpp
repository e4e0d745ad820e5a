#include "palpate/formats/internal/text_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "palpate/core/csv.h"
#include "palpate/core/text.h"

namespace palpate::formats {
namespace {

constexpr int kLinesLookedAt = 20;

bool is_comment(std::string_view line) { return line.empty() || line.front() == '#' || line.front() == '%'; }

bool has_outside_quotes(std::string_view line, char wanted) {
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (!quoted && c == wanted) return true;
  }
  return false;
}

std::string_view without_quotes(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
    cell = trimmed(cell.substr(1, cell.size() - 2));
  return cell;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") + 1 - first);
}

std::optional<std::string_view> next_line(std::string_view& content) {
  if (content.empty()) return std::nullopt;
  const auto end = content.find_first_of("\r\n");
  const auto line = content.substr(0, end);
  content.remove_prefix(end == std::string_view::npos ? content.size() : end + 1);
  if (end != std::string_view::npos && content.starts_with('\n') && line.data()[end] == '\r')
    content.remove_prefix(1);
  return line;
}

// What most lines hold separates them: a label may hold a semicolon, and a number a comma.
Separation separation_of(std::string_view content) {
  std::size_t commas = 0, semicolons = 0, tabs = 0;  // lines with some
  int looked = 0;
  while (looked < kLinesLookedAt) {
    const auto line = next_line(content);
    if (!line) break;
    if (trimmed(*line).empty()) continue;
    ++looked;
    commas += has_outside_quotes(*line, ',') ? 1 : 0;
    semicolons += has_outside_quotes(*line, ';') ? 1 : 0;
    tabs += has_outside_quotes(*line, '\t') ? 1 : 0;
  }
  if (semicolons > 0 && semicolons >= tabs && semicolons >= commas) return {';', commas > 0};
  if (tabs > 0 && tabs >= commas) return {'\t', commas > 0};
  return {commas > 0 ? ',' : ' ', false};
}

std::vector<std::string_view> cells_of(std::string_view line, char separator, std::size_t most) {
  std::vector<std::string_view> cells;
  if (separator == ' ') {
    while (cells.size() < most) {
      line = trimmed(line);
      if (line.empty()) break;
      const auto end = line.find_first_of(" \t");
      cells.push_back(without_quotes(line.substr(0, end)));
      line.remove_prefix(end == std::string_view::npos ? line.size() : end);
    }
    return cells;
  }
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= line.size() && cells.size() < most; ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || line[i] != separator)) continue;
    cells.push_back(without_quotes(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  return cells;
}

std::optional<double> number_of(std::string_view cell, bool decimal_commas) {
  std::string with_point;
  if (decimal_commas && cell.find(',') != std::string_view::npos) {
    with_point = cell;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    cell = with_point;
  }
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (cell.empty() || code != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

bool is_missing(std::string_view cell) {
  constexpr std::array kWords = {"", "nan", "NaN", "NAN", "NA", "null", "None", "-nan", "-nan(ind)"};
  return std::find(kWords.begin(), kWords.end(), cell) != kWords.end();
}

Expected<NumberRows> number_rows(std::string_view content, const std::string& source) {
  const Separation separation = separation_of(content);
  NumberRows table;
  std::size_t cells_in_all = 0;
  int number = 0;
  while (const auto raw = next_line(content)) {
    ++number;
    const auto line = trimmed(*raw);
    if (is_comment(line)) continue;
    auto cells = cells_of(line, separation.separator, kMostTableColumns);
    if (!cells.empty() && cells.back().empty()) cells.pop_back();  // a separator at the end
    cells_in_all += cells.size();
    if (table.rows.size() == kMostTableRows || cells_in_all > kMostTableCells)
      return wrong_use("{}:{}: a table of at most {} rows and {} cells is expected; split it", source, number,
                       kMostTableRows, kMostTableCells);
    std::vector<double> row;
    row.reserve(cells.size());
    for (const auto cell : cells) {
      const auto value = is_missing(cell) ? std::optional(std::numeric_limits<double>::quiet_NaN())
                                          : number_of(cell, separation.decimal_commas);
      if (!value)
        return wrong_use("{}:{}: '{}' is no finite number; rows of numbers are expected", source, number,
                         excerpt(cell, 24));
      row.push_back(*value);
    }
    table.rows.push_back(std::move(row));
    table.line.push_back(number);
  }
  return table;
}

}  // namespace palpate::formats
