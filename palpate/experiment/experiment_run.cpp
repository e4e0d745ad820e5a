#include "palpate/experiment/experiment_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate::experiment {
namespace {

bool is_positive(const Conditions& conditions, const Trial& trial, const Answer& answer) {
  return answer.place == (conditions.task == TaskKind::yes_no ? 1 : trial.target);
}

// A trial that is left out may be without an answer.
bool names_a_place(const Conditions& conditions, const Answer& answer) {
  return answer.place >= (answer.exclusion == Exclusion::none ? 1 : 0) &&
         answer.place <= std::max(2, conditions.places);
}

// Files hold stimuli with twelve digits.
bool same_trial(const Trial& a, Trial b) {
  const bool same_stimulus = std::abs(a.stimulus - b.stimulus) <= 1e-10 * std::abs(a.stimulus);
  b.stimulus = a.stimulus;
  return same_stimulus && a == b;
}

}  // namespace

ExperimentRun::ExperimentRun(Conditions conditions, std::uint64_t seed)
    : conditions_(std::move(conditions)),
      seed_(seed),
      cells_(cells_of(conditions_)),
      places_random_(seed, "experiment/staircase places") {
  for (auto& trial : practice_trials(conditions_, seed)) planned_.push_back(trial);
  most_ = conditions_.practice + experiment::most_trials(conditions_);
  if (conditions_.method == Method::constant_stimuli) {
    for (auto& trial : constant_trials(conditions_, seed)) planned_.push_back(trial);
  } else {
    const std::size_t count = cells_.size() * static_cast<std::size_t>(conditions_.tracks);
    staircases_.emplace(std::vector<StaircaseRule>(count, conditions_.rule), seed);
    track_places_.assign(count, BalancedPlaces(conditions_.places, places_random_));
  }
  auto first = upcoming();
  if (!first) throw std::invalid_argument("run: the conditions have no trial");
  next_ = *first;
}

const Trial& ExperimentRun::next_trial() const {
  if (state_ != RunState::trial) throw std::logic_error("run: no trial is due");
  return next_;
}

TrialRecord ExperimentRun::answer(const Answer& answer) {
  TrialRecord record{next_trial(), answer, false};
  const bool left_out = answer.exclusion != Exclusion::none;
  if (!names_a_place(conditions_, answer))
    throw std::invalid_argument(fmt::format("run: the answer {} names no place", answer.place));
  record.positive = is_positive(conditions_, next_, answer);
  ++answered_;
  if (!next_.practice && staircases_) {
    staircases_->answer(left_out ? std::nullopt : std::optional(record.positive));
  } else if (left_out && !next_.practice && conditions_.repeat_excluded && next_.repeated < kMostRepeats) {
    planned_.push_back(next_);
    ++planned_.back().repeated;
  }
  advance();
  return record;
}

void ExperimentRun::end_rest() {
  if (state_ != RunState::rest) throw std::logic_error("run: there is no rest to end");
  state_ = RunState::trial;
}

void ExperimentRun::advance() {
  const bool was_practice = next_.practice;
  const auto coming = upcoming();
  if (!coming) {
    state_ = RunState::finished;
    return;
  }
  next_ = *coming;
  since_rest_ = was_practice ? 0 : since_rest_ + 1;
  const bool practised = was_practice && !next_.practice;
  const bool due = !was_practice && conditions_.rest_after > 0 && since_rest_ >= conditions_.rest_after;
  if (due) since_rest_ = 0;
  if (practised || due) state_ = RunState::rest;
}

std::optional<Trial> ExperimentRun::upcoming() {
  Trial trial;
  if (!planned_.empty()) {
    trial = planned_.front();
    planned_.pop_front();
  } else if (staircases_ && !staircases_->finished()) {
    trial = of_staircase();
  } else {
    return std::nullopt;
  }
  trial.number = answered_ + 1;
  return trial;
}

Trial ExperimentRun::of_staircase() {
  const auto whose = staircases_->next();
  const auto tracks = static_cast<std::size_t>(conditions_.tracks);
  return {.track = static_cast<int>(whose % tracks) + 1,
          .cell = whose / tracks,
          .stimulus = staircases_->stimulus(),
          .target = track_places_[whose].next()};
}

Expected<void> ExperimentRun::take_up(std::span<const TrialRecord> records, std::string_view source) {
  for (const auto& record : records) {
    if (state_ == RunState::rest) end_rest();
    if (state_ == RunState::finished)
      return refused(
          "{}: has trials after the last one of these conditions; use the ones the file was begun with",
          source);
    if (!same_trial(next_, record.trial))
      return refused(
          "{}: trial {} is not the one that these conditions and seed {} give; use the ones the file "
          "was begun with",
          source, record.trial.number, seed_);
    if (!names_a_place(conditions_, record.answer) || answer(record.answer).positive != record.positive)
      return refused(
          "{}: trial {}: response is not what target and answer say; use the file as it was written", source,
          record.trial.number);
  }
  return {};
}

const std::string& ExperimentRun::level_of(const Trial& trial, std::string_view factor) const {
  for (std::size_t i = 0; i < conditions_.factors.size(); ++i)
    if (conditions_.factors[i].name == factor) return levels_of(trial)[i];
  throw std::out_of_range(fmt::format("run: there is no factor {}", factor));
}

const std::vector<Staircase>& ExperimentRun::staircases() const {
  static const std::vector<Staircase> none;
  return staircases_ ? staircases_->all() : none;
}

}  // namespace palpate::experiment
