// What finished searches lead to: the level of the next one, a line in a person's file. The thread that prepares trials; the
// physics loop hands over what was found as plain bytes.
#pragma once

#include <cstdint>
#include <optional>

#include "applications/palpation/difficulty.h"
#include "applications/palpation/learning_file.h"
#include "applications/palpation/settings.h"

namespace palpate::applications::palpation {

struct FinishedSearch {
  std::int32_t trial = 0;
  std::int32_t level = -1;  // below 0: the nodules were drawn
  std::int32_t nodules = 0, found = 0, false_alarms = 0, hard_presses = 0;
  double error = 0.0;                                  // m, median of those found; no number for none
  double seconds = 0.0, path = 0.0, peak_force = 0.0;  // s, m, N
};

class Training {
 public:
  // Opens the settings' file, unless nothing is kept. Throws std::runtime_error where it cannot be.
  Training(const PalpationSettings& settings, bool keeps_files);

  // A line that cannot be written is warned of once, and left out.
  void hear(const FinishedSearch& search);
  std::optional<int> level() const;  // of the next search; none: nodules are drawn

 private:
  std::optional<DifficultyStaircase> staircase_;
  std::optional<LearningFile> file_;
  bool warned_ = false;
};

}  // namespace palpate::applications::palpation
