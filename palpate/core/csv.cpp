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

std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> cells;
  while (true) {
    const auto comma = line.find(',');
    cells.emplace_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
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

bool is_name(std::string_view cell) {
  return cell.size() <= kLongestName && excerpt(cell, kLongestName) == cell;
}

std::string shown(std::string_view cell) { return excerpt(cell, 24); }

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
                         source, line[i],
                         header.empty() ? fmt::format("column {}", column + 1) : shown(header[column]),
                         rows[i][column], limit);
  return {};
}

Expected<CsvTable> parse_csv(std::string_view content, std::string source, const CsvOptions& options) {
  CsvTable table;
  table.source = std::move(source);
  if (looks_binary(content))
    return wrong_use("{}: is not a text file; a CSV table is expected", table.source);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // what spreadsheets put before UTF-8
  if (content.starts_with(kByteOrderMark)) content.remove_prefix(kByteOrderMark.size());
  std::size_t width = 0;
  std::vector<bool> may_be_text;
  bool first = true;
  int line_number = 0;
  while (!content.empty()) {
    const auto end = content.find('\n');
    const auto line = trimmed(content.substr(0, end));
    content.remove_prefix(end == std::string_view::npos ? content.size() : end + 1);
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    auto cells = split(line);
    if (first) {
      first = false;
      width = cells.size();
      may_be_text.assign(width, false);
      const bool header = std::any_of(cells.begin(), cells.end(), [](const auto& c) { return !number(c); });
      if (header) {
        table.header = std::move(cells);
        for (std::size_t i = 0; i < width; ++i)
          for (const auto& name : options.text_columns)
            if (name == "*" || name == table.header[i]) may_be_text[i] = true;
        continue;
      }
    }
    if (cells.size() != width)
      return wrong_use("{}:{}: {}, but the first line has {}; repair or remove the row", table.source,
                       line_number, counted(cells.size(), "cell"), width);
    std::vector<double> row(width);
    for (std::size_t i = 0; i < width; ++i) {
      const auto value = number(cells[i]);
      const std::string column =
          table.header.empty() ? fmt::format("column {}", i + 1) : shown(table.header[i]);
      if (value && std::isfinite(*value)) {
        row[i] = *value;
      } else if (may_be_text[i]) {
        if (!is_name(cells[i]))
          return wrong_use(
              "{}:{}: {} is '{}'; a name of at most {} bytes without control characters is expected",
              table.source, line_number, column, shown(cells[i]), kLongestName);
        row[i] = std::numeric_limits<double>::quiet_NaN();
      } else if (value) {
        return wrong_use("{}:{}: {} is '{}'; finite numbers are expected, remove or repair the row",
                         table.source, line_number, column, shown(cells[i]));
      } else {
        return wrong_use("{}:{}: {} is '{}', a number is expected", table.source, line_number, column,
                         shown(cells[i]));
      }
    }
    table.rows.push_back(std::move(row));
    table.text.push_back(std::move(cells));
    table.line.push_back(line_number);
  }
  if (first) return wrong_use("{}: is empty; a CSV table is expected", table.source);
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
