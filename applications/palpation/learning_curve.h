// What a file of searches shows of its sessions: figures of each, with intervals, and how they are drawn. SI inside, units
// in keys and labels. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "applications/palpation/learning_file.h"
#include "palpate/scene/application_study.h"

namespace palpate::applications::palpation {

// A share and where it may be, at 95 of 100.
struct ShareInterval {
  double share = 0.0, low = 0.0, high = 1.0;
};
// None for none of none. Source: Wilson (1927), "Probable inference, the law of succession, and statistical inference".
std::optional<ShareInterval> wilson_interval(int positives, int trials);

struct SessionFigures {
  int session = 0;
  std::string date;  // of its first search
  int searches = 0, nodules = 0, found = 0, false_alarms = 0;
  std::optional<ShareInterval> found_share;  // none: there was nothing to find
  double seconds = 0.0;                      // median of its searches
  std::optional<double> position_error;      // m, median of its searches'
  std::optional<double> late_level;  // mean over its last half, the middle one included; none: no staircase
};
// In the order of their numbers.
std::vector<SessionFigures> sessions_of(std::span<const LearningLine> lines);

// `source`: the file, as a person knows it. At least one line.
scene::StudyOutcome learning_outcome(std::span<const LearningLine> lines, const std::string& source);

}  // namespace palpate::applications::palpation
