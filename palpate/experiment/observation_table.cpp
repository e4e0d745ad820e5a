#include "palpate/experiment/observation_table.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"

namespace palpate::experiment {
namespace {

constexpr double kMostCount = 1e6;

// Where each thing stands; counts where there is no response.
struct Columns {
  std::size_t stimulus = 0;
  std::optional<std::size_t> response, positives, trials, practice, excluded;
  std::vector<std::size_t> by;
};

Expected<Columns> columns_of(const CsvTable& table, const ObservationOptions& options) {
  Columns columns;
  const auto stimulus = table.require(options.stimulus);
  if (!stimulus) return tl::unexpected(stimulus.error());
  columns.stimulus = *stimulus;
  columns.response = table.find(options.response);
  columns.positives = table.find("positives");
  columns.trials = table.find("trials");
  if (!columns.response && !(columns.positives && columns.trials))
    return wrong_use(
        "{}: has neither a column '{}' (1 or 0) nor 'positives' and 'trials' (counts); name the column with "
        "--response",
        table.source, excerpt(options.response));
  columns.practice = table.find("practice");
  columns.excluded = table.find("excluded");
  for (const auto& name : options.by) {
    const auto at = table.require(name);
    if (!at) return tl::unexpected(at.error());
    columns.by.push_back(*at);
  }
  return columns;
}

class ObservationReader {
 public:
  ObservationReader(const CsvTable& table, const Columns& columns, ObservationTable& result)
      : table_(&table), columns_(&columns), result_(&result) {}

  Expected<void> take(std::size_t row) {
    if (columns_->practice && is_one(row, *columns_->practice)) return ++result_->practice, failure();
    if (columns_->excluded && is_one(row, *columns_->excluded)) return ++result_->excluded, failure();
    Level level{number(row, columns_->stimulus), 0, 1};
    if (!(level.stimulus > 0.0)) complain(row, columns_->stimulus, "a stimulus above 0 is expected");
    if (columns_->response) {
      level.positives = is_one(row, *columns_->response) ? 1 : 0;
    } else {
      level.positives = count(row, *columns_->positives);
      level.trials = count(row, *columns_->trials);
      if (level.positives > level.trials)
        complain(row, *columns_->positives, fmt::format("at most {} (trials) is expected", level.trials));
    }
    if (const auto failed = failure(); !failed) return failed;
    return add(row, level);
  }

  void finish() {
    for (std::size_t i = 0; i < result_->groups.size(); ++i)
      for (const auto& [stimulus, level] : levels_[i]) result_->groups[i].levels.push_back(level);
  }

 private:
  double number(std::size_t row, std::size_t column) const { return table_->rows[row][column]; }
  bool is_one(std::size_t row, std::size_t column) {
    const double value = number(row, column);
    if (value != 0.0 && value != 1.0) complain(row, column, "1 or 0 is expected");
    return value == 1.0;
  }
  int count(std::size_t row, std::size_t column) {
    const double value = number(row, column);
    if (value >= 0.0 && value <= kMostCount && value == std::floor(value)) return static_cast<int>(value);
    complain(row, column, fmt::format("a whole number of 0 to {} is expected", kMostCount));
    return 0;
  }
  void complain(std::size_t row, std::size_t column, std::string_view expectation) {
    if (error_.empty())
      error_ = fmt::format("{}:{}: {} is '{}'; {}", table_->source, table_->line[row],
                           excerpt(table_->header[column]), excerpt(table_->text[row][column]), expectation);
  }
  Expected<void> failure() const {
    if (error_.empty()) return {};
    return wrong_use("{}", error_);
  }

  Expected<void> add(std::size_t row, const Level& level) {
    std::vector<std::string> key;
    for (const auto column : columns_->by) key.push_back(table_->text[row][column]);
    const auto [at, is_new] = index_.emplace(key, levels_.size());
    if (is_new) {
      if (levels_.size() == kMostGroups)
        return wrong_use("{}:{}: more than {} groups; use fewer columns after --by", table_->source,
                         table_->line[row], kMostGroups);
      levels_.emplace_back();
      auto& group = result_->groups.emplace_back();
      for (std::size_t i = 0; i < key.size(); ++i)
        group.by.emplace_back(table_->header[columns_->by[i]], key[i]);
    }
    auto& sum = levels_[at->second].try_emplace(level.stimulus, Level{level.stimulus, 0, 0}).first->second;
    if (levels_[at->second].size() > kMostLevels)
      return wrong_use("{}:{}: more than {} different stimuli in one group; use rounded ones", table_->source,
                       table_->line[row], kMostLevels);
    if (sum.trials > static_cast<int>(1000.0 * kMostCount))
      return wrong_use("{}:{}: too many trials of one stimulus; at most 1000000000 are expected",
                       table_->source, table_->line[row]);
    sum.positives += level.positives;
    sum.trials += level.trials;
    result_->trials += level.trials;
    return {};
  }

  const CsvTable* table_;
  const Columns* columns_;
  ObservationTable* result_;
  std::map<std::vector<std::string>, std::size_t> index_;
  std::vector<std::map<double, Level>> levels_;
  std::string error_;
};

}  // namespace

Expected<ObservationTable> parse_observations(std::string_view content, std::string source,
                                              const ObservationOptions& options) {
  CsvOptions csv;
  csv.text_columns = {"*"};
  const auto table = parse_csv(content, std::move(source), csv);
  if (!table) return tl::unexpected(table.error());
  const auto columns = columns_of(*table, options);
  if (!columns) return tl::unexpected(columns.error());
  ObservationTable result;
  result.source = table->source;
  ObservationReader reader(*table, *columns, result);
  for (std::size_t i = 0; i < table->rows.size(); ++i)
    if (const auto taken = reader.take(i); !taken) return tl::unexpected(taken.error());
  reader.finish();
  if (result.trials == 0)
    return refused("{}: holds no trial that counts ({} of practice, {} left out); one or more are expected",
                   result.source, result.practice, result.excluded);
  return result;
}

Expected<ObservationTable> read_observations(const std::filesystem::path& path,
                                             const ObservationOptions& options) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_observations(*content, path.string(), options);
}

std::string label_of(const ObservationGroup& group) {
  std::string label;
  for (const auto& [column, value] : group.by)
    label += fmt::format("{}{} {}", label.empty() ? "" : ", ", column, value);
  return label.empty() ? "all" : label;
}

}  // namespace palpate::experiment
