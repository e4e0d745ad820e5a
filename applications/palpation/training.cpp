#include "applications/palpation/training.h"

#include <array>
#include <cmath>
#include <ctime>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpate/core/log.h"

namespace palpate::applications::palpation {
namespace {

constexpr Log kTrainingLog("palpation");

std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc)};
}

LearningLine line_of(const FinishedSearch& search) {
  LearningLine line;
  line.trial = search.trial;
  line.date = date_now();
  if (search.level >= 0) line.level = search.level;
  line.nodules = search.nodules;
  line.found = search.found;
  line.false_alarms = search.false_alarms;
  if (std::isfinite(search.error)) line.position_error = search.error;
  line.seconds = search.seconds;
  line.path = search.path;
  line.hard_presses = search.hard_presses;
  line.peak_force = search.peak_force;
  return line;
}

}  // namespace

Training::Training(const PalpationSettings& settings, bool keeps_files) {
  if (settings.difficulty == Difficulty::staircase) staircase_.emplace(settings.level);
  if (settings.learning_file.empty() || !keeps_files) return;
  auto file = LearningFile::open(settings.learning_file);
  if (!file) throw std::runtime_error(file.error().message);
  file_.emplace(std::move(*file));
}

void Training::hear(const FinishedSearch& search) {
  if (staircase_) staircase_->answer(answers_positively(search.nodules, search.found, search.false_alarms));
  if (!file_) return;
  const auto added = file_->add(line_of(search));
  if (!added && !std::exchange(warned_, true))
    kTrainingLog.warning("warning: a search is not kept: {}", added.error().message);
}

std::optional<int> Training::level() const {
  return staircase_ ? std::optional(staircase_->level()) : std::nullopt;
}

}  // namespace palpate::applications::palpation
