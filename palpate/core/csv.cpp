#include "palpate/core/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpate/core/file.h"
#include "palpate/core/file_form.h"
#include "palpate/core/lower_case.h"
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
  table.no_number.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (const auto& name : options.text_columns)
      if (name == "*" || name == table.header[i]) may_be_text[i] = true;
  return true;
}

tl::unexpected<Error> complaint(const CsvTable& table, int line, std::size_t column, std::string_view cell,
                                std::string_view expectation) {
  return wrong_use("{}:{}: {} is '{}'{}", table.source, line, column_name(table, column), shown(cell),
                   expectation);
}

tl::unexpected<Error> is_no_number(const CsvTable& table, int line, std::size_t column,
                                   std::string_view cell) {
  return complaint(
      table, line, column, cell,
      number(cell) ? "; finite numbers are expected, remove or repair the row" : ", a number is expected");
}

// A cell that is no finite number: text where its column may hold text, else noted for who asks for the column.
// Without a header nobody asks by name, and every column counts.
Expected<void> take_word(CsvTable& table, int line, std::size_t column, std::string_view cell,
                         bool may_be_text) {
  if (may_be_text) {
    if (is_name(cell)) return {};
    return complaint(
        table, line, column, cell,
        fmt::format("; a name of at most {} bytes without control characters is expected", kLongestName));
  }
  if (table.header.empty()) return is_no_number(table, line, column, cell);
  if (!table.no_number[column]) table.no_number[column] = table.rows.size();
  return {};
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
  // Its words would pass for those of a row in which a body was hidden.
  if (!table.header.empty() && std::equal(cells.begin(), cells.end(), table.header.begin()))
    return wrong_use("{}:{}: the header stands here once more; remove the line", table.source, line);
  std::vector<double> row(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (const auto value = number(cells[i]); value && std::isfinite(*value)) {
      row[i] = *value;
    } else {
      row[i] = std::numeric_limits<double>::quiet_NaN();
      if (auto taken = take_word(table, line, i, cells[i], may_be_text[i]); !taken) return taken;
    }
  }
  table.rows.push_back(std::move(row));
  table.text.emplace_back(cells.begin(), cells.end());
  table.line.push_back(line);
  return {};
}

}  // namespace

std::optional<std::size_t> CsvTable::find(std::string_view column) const {
  auto at = std::find(header.begin(), header.end(), column);
  if (at == header.end()) {
    const std::string wanted = lower_case(column);
    at = std::find_if(header.begin(), header.end(),
                      [&](const std::string& name) { return lower_case(name) == wanted; });
  }
  if (at == header.end()) return std::nullopt;
  return static_cast<std::size_t>(at - header.begin());
}

Expected<std::size_t> CsvTable::require(std::string_view column) const {
  if (const auto at = find(column)) {
    if (const auto fine = require_numbers({*at}); !fine) return tl::unexpected(fine.error());
    return *at;
  }
  if (header.empty())
    return wrong_use("{}: column '{}' is needed, but the file has no header line", source, column);
  std::string names;
  for (const auto& name : header) names += (names.empty() ? "" : ",") + shown(name);
  if (names.size() > 160) names = names.substr(0, 160) + "...";
  return wrong_use("{}: column '{}' is missing; the header reads {}", source, column, names);
}

Expected<void> CsvTable::require_numbers(const std::vector<std::size_t>& at) const {
  for (const auto column : at)
    if (const auto row = column < no_number.size() ? no_number[column] : std::nullopt)
      return is_no_number(*this, line[*row], column, text[*row][column]);
  return {};
}

Expected<void> CsvTable::require_within(const std::vector<std::size_t>& at, double limit) const {
  if (auto fine = require_numbers(at); !fine) return fine;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const auto column : at)
      if (std::abs(rows[i][column]) > limit)
        return wrong_use("{}:{}: {} is {:g}; at most {:g} is expected, check the unit or remove the row",
                         source, line[i], column_name(*this, column), rows[i][column], limit);
  return {};
}

std::size_t CsvTable::leave_out_rows_without(const std::vector<std::size_t>& at) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (std::all_of(at.begin(), at.end(), [&](std::size_t column) { return std::isnan(rows[i][column]); }))
      continue;
    if (kept != i) {
      rows[kept] = std::move(rows[i]);
      text[kept] = std::move(text[i]);
      line[kept] = line[i];
    }
    ++kept;
  }
  const std::size_t left_out = rows.size() - kept;
  if (left_out == 0) return 0;
  rows.resize(kept), text.resize(kept), line.resize(kept);
  for (std::size_t column = 0; column < no_number.size(); ++column) {
    if (!no_number[column]) continue;
    no_number[column].reset();
    for (std::size_t i = 0; i < kept && !no_number[column]; ++i)
      if (std::isnan(rows[i][column])) no_number[column] = i;
  }
  return left_out;
}

Expected<CsvTable> parse_csv(std::string_view content, std::string source, const CsvOptions& options) {
  CsvTable table;
  table.source = std::move(source);
  content = without_byte_order_mark(content);
  if (const auto fine = may_be_table(content, table.source); !fine) return tl::unexpected(fine.error());
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
