// Answers of an experiment as a table, whoever wrote it: our files of trials, or a person's own.
//
// Needed are the stimulus (above 0) and either `response` (1 positive, 0 not; a line a trial) or `positives` and `trials`
// (counts). Lines whose `practice` or `excluded` is 1 are left out and counted. Columns named in `by` split the answers into
// groups, in the order in which they first appear. Pure but for reading. Errors: wrong use for what a line does wrong, with
// file, line and column; refused where no answer is left.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/experiment/psychometric.h"

namespace palpate::experiment {

struct ObservationOptions {
  std::string stimulus = "stimulus";  // names of columns
  std::string response = "response";
  std::vector<std::string> by;
};

struct ObservationGroup {
  std::vector<std::pair<std::string, std::string>> by;  // column and what stands there
  std::vector<Level> levels;                            // rising
};

struct ObservationTable {
  std::string source;
  std::vector<ObservationGroup> groups;
  int trials = 0, practice = 0, excluded = 0;  // counted in, and left out
};

inline constexpr std::size_t kMostGroups = 200;
inline constexpr std::size_t kMostLevels = 20'000;  // of a group

Expected<ObservationTable> read_observations(const std::filesystem::path& path,
                                             const ObservationOptions& options);
Expected<ObservationTable> parse_observations(std::string_view content, std::string source,
                                              const ObservationOptions& options);

// "sight with, depth_mm 5"; "all" of no columns.
std::string label_of(const ObservationGroup& group);

}  // namespace palpate::experiment
