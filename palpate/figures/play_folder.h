// What a play left in its folder (summary.json, raw/*.csv, pictures), read tolerantly: a missing file or key is
// simply not there, and its part of the report is left out. One thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/core/json.h"

namespace palpate::figures {

class PlayFolder {
 public:
  static Expected<PlayFolder> read(const std::filesystem::path& folder);

  // A value of summary.json by its path ("arm/error_to_truth_mean_mm").
  std::optional<double> number(std::string_view path) const;
  std::optional<std::string> text(std::string_view path) const;
  const Json* find(std::string_view path) const;
  const Json& summary() const { return summary_; }

  // raw/NAME as a table; none where it is missing or has no rows. A file that is there and broken is an error
  // at read.
  const CsvTable* raw(std::string_view name) const;
  const std::vector<std::pair<std::string, CsvTable>>& tables() const { return tables_; }  // all of raw/
  // A file's bytes; empty where it is missing.
  std::string bytes(std::string_view name) const;
  bool has(std::string_view name) const;
  // Names of the PNG files in a folder, sorted, with the folder in front ("pictures/a.png").
  std::vector<std::string> pictures(std::string_view folder) const;

 private:
  std::filesystem::path folder_;
  Json summary_;
  std::vector<std::pair<std::string, CsvTable>> tables_;
};

// A column of numbers; empty where the table has none of that name.
std::vector<double> column(const CsvTable& table, std::string_view name);
bool has_columns(const CsvTable& table, std::initializer_list<std::string_view> names);

// "0.123 mm": at most `digits` significant digits, no idle zeros; a dash where there is no value.
std::string shown(std::optional<double> value, std::string_view unit, int digits = 3);

}  // namespace palpate::figures
