#include "palpate/core/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpate/core/file.h"
#include "palpate/core/text.h"

namespace palpate::inline core {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::optional<double> number(std::string_view cell) {
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (code == std::errc::result_out_of_range && end == cell.data() + cell.size())
    return std::numeric_limits<double>::infinity();
  if (code != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

// False where there are more than a table has columns.
bool split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  while (cells.size() < kMostTableColumns) {
    const auto comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return true;
    line.remove_prefix(comma + 1);
  }
  return false;
}

bool looks_binary(std::string_view content) {
  const auto head = content.substr(0, 4096);
  const auto odd = std::count_if(head.begin(), head.end(), [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return u < 9 || (u > 13 && u < 32) || u == 127;
  });
  return odd > 0;
}

// What a text column may hold: messages, reports and rig files will quote it.
constexpr std::size_t kLongestName = 120;

// Labels in Latin-1 are let pass: tables of old programs hold them.
bool is_name(std::string_view cell) { return cell.size() <= kLongestName && !has_control(cell); }

std::string shown(std::string_view cell) { return excerpt(cell, 24); }

std::string column_name(const CsvTable& table, std::size_t column) {
  return table.header.empty() ? fmt::format("column {}", column + 1) : shown(table.header[column]);
}

// The first line's cells: a header where one of them is no number.
bool take_header(CsvTable& table, const std::vector<std::string_view>& cells, const CsvOptions& options,
                 std::vector<bool>& may_be_text) {
  may_be_text.assign(cells.size(), false);
  if (std::all_of(cells.begin(), cells.end(), [](auto cell) { return number(cell).has_value(); }))
    return false;
  table.header.assign(cells.begin(), cells.end());
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (const auto& name : options.text_columns)
      if (name == "*" || name == table.header[i]) may_be_text[i] = true;
  return true;
}

// A cell that is no finite number: a name where its column may hold names, else the reason why not.
Expected<double> take_word(const CsvTable& table, int line, std::size_t column, std::string_view cell,
                           bool may_be_text) {
  const auto place = [&] { return fmt::format("{}:{}: {}", table.source, line, column_name(table, column)); };
  if (may_be_text) {
    if (is_name(cell)) return std::numeric_limits<double>::quiet_NaN();
    return wrong_use("{} is '{}'; a name of at most {} bytes without control characters is expected", place(),
                     shown(cell), kLongestName);
  }
  if (number(cell))
    return wrong_use("{} is '{}'; finite numbers are expected, remove or repair the row", place(),
                     shown(cell));
  return wrong_use("{} is '{}', a number is expected", place(), shown(cell));
}

Expected<void> take_row(CsvTable& table, int line, const std::vector<std::string_view>& cells,
                        const std::vector<bool>& may_be_text) {
  if (cells.size() != may_be_text.size())
    return wrong_use("{}:{}: {}, but the first line has {}; repair or remove the row", table.source, line,
                     counted(cells.size(), "cell"), may_be_text.size());
  if (table.rows.size() == kMostTableRows || (table.rows.size() + 1) * cells.size() > kMostTableCells)
    return wrong_use(
        "{}:{}: a table of at most {} rows and {} cells is expected; split it, or keep every second row",
        table.source, line, kMostTableRows, kMostTableCells);
  std::vector<double> row(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (const auto value = number(cells[i]); value && std::isfinite(*value)) {
      row[i] = *value;
    } else {
      const auto word = take_word(table, line, i, cells[i], may_be_text[i]);
      if (!word) return tl::unexpected(word.error());
      row[i] = *word;
    }
  }
  table.rows.push_back(std::move(row));
  table.text.emplace_back(cells.begin(), cells.end());
  table.line.push_back(line);
  return {};
}

}  // namespace

std::optional<std::size_t> CsvTable::find(std::string_view column) const {
  const auto at = std::find(header.begin(), header.end(), column);
  if (at == header.end()) return std::nullopt;
  return static_cast<std::size_t>(at - header.begin());
}

Expected<std::size_t> CsvTable::require(std::string_view column) const {
  if (const auto at = find(column)) return *at;
  if (header.empty())
    return wrong_use("{}: column '{}' is needed, but the file has no header line", source, column);
  std::string names;
  for (const auto& name : header) names += (names.empty() ? "" : ",") + shown(name);
  if (names.size() > 160) names = names.substr(0, 160) + "...";
  return wrong_use("{}: column '{}' is missing; the header reads {}", source, column, names);
}

Expected<void> CsvTable::require_within(const std::vector<std::size_t>& at, double limit) const {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const auto column : at)
      if (std::abs(rows[i][column]) > limit)
        return wrong_use("{}:{}: {} is {:g}; at most {:g} is expected, check the unit or remove the row",
                         source, line[i], column_name(*this, column), rows[i][column], limit);
  return {};
}

Expected<CsvTable> parse_csv(std::string_view content, std::string source, const CsvOptions& options) {
  CsvTable table;
  table.source = std::move(source);
  if (looks_binary(content))
    return wrong_use("{}: is not a text file; a CSV table is expected", table.source);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // what spreadsheets put before UTF-8
  if (content.starts_with(kByteOrderMark)) content.remove_prefix(kByteOrderMark.size());
  std::vector<std::string_view> cells;
  std::vector<bool> may_be_text;  // of each column; empty before the first line
  int line_number = 0;
  while (!content.empty()) {
    const auto end = content.find('\n');
    const auto line = trimmed(content.substr(0, end));
    content.remove_prefix(end == std::string_view::npos ? content.size() : end + 1);
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    if (!split(line, cells))
      return wrong_use("{}:{}: has more than {} cells; a table of fewer columns is expected", table.source,
                       line_number, kMostTableColumns);
    if (may_be_text.empty() && take_header(table, cells, options, may_be_text)) continue;
    if (const auto done = take_row(table, line_number, cells, may_be_text); !done)
      return tl::unexpected(done.error());
  }
  if (may_be_text.empty()) return wrong_use("{}: is empty; a CSV table is expected", table.source);
  return table;
}

Expected<CsvTable> read_csv(const std::filesystem::path& path, const CsvOptions& options) {
  auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_csv(*content, path.string(), options);
}

std::string number_text(double value) { return fmt::format("{:.12g}", value); }

CsvWriter::CsvWriter(std::vector<std::string> header) : columns_(header.size()) { row(header); }

void CsvWriter::row(const std::vector<double>& values) {
  std::vector<std::string> cells;
  cells.reserve(values.size());
  for (double value : values) cells.push_back(number_text(value));
  row(cells);
}

void CsvWriter::row(const std::vector<std::string>& cells) {
  if (cells.size() != columns_) throw std::logic_error("CsvWriter: row width differs from the header's");
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) content_ += ',';
    content_ += cells[i];
  }
  content_ += '\n';
}

}  // namespace palpate::inline core
