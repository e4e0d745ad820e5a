#include "applications/palpation/learning_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "applications/palpation/score.h"
#include "applications/palpation/settings.h"
#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::applications::palpation {
namespace {

// What each column may hold. `empty`: nothing, too.
struct LearningColumn {
  const char* name;
  double least, most;
  bool whole, empty = false;
};
constexpr double kMostCounted = 1e6, kMostMeasured = 1e6;
constexpr std::size_t kDate = 2;
constexpr std::array<LearningColumn, 12> kColumns{{{"session", 1, kMostCounted, true},
                                                   {"trial", 1, kMostCounted, true},
                                                   {"date", 0, 0, false, true},  // a text
                                                   {"level", 0, kHardestLevel, true, true},
                                                   {"nodules", 0, static_cast<double>(kMostNodules), true},
                                                   {"found", 0, static_cast<double>(kMostNodules), true},
                                                   {"false_alarms", 0, static_cast<double>(kMostMarks), true},
                                                   {"position_error_mm", 0, kMostMeasured, false, true},
                                                   {"seconds", 0, kMostMeasured, false},
                                                   {"path_m", 0, kMostMeasured, false},
                                                   {"hard_presses", 0, kMostCounted, true},
                                                   {"force_peak_n", 0, kMostMeasured, false}}};

std::string header_text() {
  std::string text;
  for (const auto& column : kColumns) text += (text.empty() ? "" : ",") + std::string(column.name);
  return text + "\n";
}

Expected<void> check_cell(const CsvTable& table, std::size_t row, std::size_t at) {
  const LearningColumn& column = kColumns[at];
  const std::string& cell = table.text[row][at];
  if (at == kDate || (column.empty && cell.empty())) return {};
  const double value = table.rows[row][at];
  if (value >= column.least && value <= column.most && (!column.whole || value == std::floor(value)))
    return {};
  return wrong_use("{}:{}: {} is '{}'; {} from {:g} to {:g}{} is expected", table.source, table.line[row],
                   column.name, excerpt(cell, 24), column.whole ? "a whole number" : "a number", column.least,
                   column.most, column.empty ? ", or nothing," : "");
}

Expected<LearningLine> line_of(const CsvTable& table, std::size_t row) {
  for (std::size_t at = 0; at < kColumns.size(); ++at)
    if (auto fine = check_cell(table, row, at); !fine) return tl::unexpected(fine.error());
  const auto& numbers = table.rows[row];
  const auto whole = [&](std::size_t at) { return static_cast<int>(numbers[at]); };
  const auto there = [&](std::size_t at) { return !table.text[row][at].empty(); };
  LearningLine line;
  line.session = whole(0);
  line.trial = whole(1);
  line.date = excerpt(table.text[row][kDate]);
  if (there(3)) line.level = whole(3);
  line.nodules = whole(4);
  line.found = whole(5);
  line.false_alarms = whole(6);
  if (there(7)) line.position_error = metres_from_mm(numbers[7]);
  line.seconds = numbers[8];
  line.path = numbers[9];
  line.hard_presses = whole(10);
  line.peak_force = numbers[11];
  if (line.found > line.nodules)
    return wrong_use("{}:{}: {} of {} nodules were found; repair or remove the row", table.source,
                     table.line[row], line.found, line.nodules);
  return line;
}

std::string text_of(const LearningLine& line) {
  return fmt::format("{},{},{},{},{},{},{},{},{:.3f},{:.3f},{},{:.3f}\n", line.session, line.trial, line.date,
                     line.level ? std::to_string(*line.level) : "", line.nodules, line.found,
                     line.false_alarms,
                     line.position_error ? fmt::format("{:.2f}", mm_from_metres(*line.position_error)) : "",
                     line.seconds, line.path, line.hard_presses, line.peak_force);
}

// As it lies there, or the beginning of one.
Expected<std::string> content_of(const std::filesystem::path& path) {
  if (!is_there(path)) return header_text();
  auto content = read_file(path, kMostLearningBytes);
  if (content && !content->empty() && content->back() != '\n') *content += '\n';
  return content;
}

}  // namespace

Expected<std::vector<LearningLine>> parse_learning(std::string_view content, std::string source) {
  const auto table = parse_csv(content, std::move(source), {{"date", "level", "position_error_mm"}});
  if (!table) return tl::unexpected(table.error());
  for (std::size_t at = 0; at < kColumns.size(); ++at) {
    const auto found = table->require(kColumns[at].name);
    if (!found) return tl::unexpected(found.error());
    if (*found != at || table->header.size() != kColumns.size())
      return wrong_use("{}: other columns than in a file of searches; its header reads {}", table->source,
                       header_text().substr(0, header_text().size() - 1));
  }
  std::vector<LearningLine> lines;
  for (std::size_t row = 0; row < table->rows.size(); ++row) {
    auto line = line_of(*table, row);
    if (!line) return tl::unexpected(line.error());
    lines.push_back(std::move(*line));
  }
  return lines;
}

Expected<std::vector<LearningLine>> read_learning(const std::filesystem::path& path) {
  const auto content = read_file(path, kMostLearningBytes);
  if (!content) return tl::unexpected(content.error());
  return parse_learning(*content, path.string());
}

Expected<std::vector<LearningLine>> read_learning_if_there(const std::filesystem::path& path) {
  if (!is_there(path)) return std::vector<LearningLine>{};
  return read_learning(path);
}

std::optional<int> newest_level(const std::vector<LearningLine>& lines) {
  const auto newest = std::find_if(lines.rbegin(), lines.rend(), [](const auto& line) { return line.level; });
  return newest == lines.rend() ? std::nullopt : newest->level;
}

Expected<LearningFile> LearningFile::open(std::filesystem::path path) {
  const auto content = content_of(path);
  if (!content) return tl::unexpected(content.error());
  const auto lines = parse_learning(*content, path.string());
  if (!lines) return tl::unexpected(lines.error());
  int session = 0;
  for (const auto& line : *lines) session = std::max(session, line.session);
  if (session >= static_cast<int>(kMostCounted))
    return wrong_use("{}: holds session {}, the last one there can be; name another file", path.string(),
                     session);
  if (auto written = write_file(path, *content); !written) return tl::unexpected(written.error());
  return LearningFile(std::move(path), session + 1);
}

Expected<void> LearningFile::add(LearningLine line) {
  auto content = content_of(path_);
  if (!content) return tl::unexpected(content.error());
  // What somebody has made of it meanwhile is not made worse.
  if (const auto lines = parse_learning(*content, path_.string()); !lines)
    return tl::unexpected(lines.error());
  line.session = session_;
  *content += text_of(line);
  if (content->size() > kMostLearningBytes)
    return refused("{}: is full; name another file for what comes next", path_.string());
  return write_file(path_, *content);
}

}  // namespace palpate::applications::palpation
