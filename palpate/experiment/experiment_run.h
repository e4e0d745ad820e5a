// An experiment that is going on: which trial comes next, given all answers so far.
//
//   ExperimentRun run(conditions, seed);
//   while (run.state() != RunState::finished) {
//     if (run.state() == RunState::rest) { ...; run.end_rest(); continue; }
//     const Trial& trial = run.next_trial();      // show it
//     const TrialRecord record = run.answer({.place = 2, .response_s = 1.4});
//   }
//
// Practice comes first, then a rest, then the trials that count, with rests between them. A trial left out (the force was
// limited, a guard tripped) does not count: of constant stimuli it comes again at the end, where the conditions say so; a
// staircase stays where it is. All follows from conditions, seed and answers; so a run that was broken off is taken up by
// giving it its answers again. One thread. Wrong use (exception): next_trial() or answer() in another state, an answer that
// names no place, conditions without a trial.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/experiment/conditions.h"
#include "palpate/experiment/staircase.h"
#include "palpate/experiment/trial.h"
#include "palpate/experiment/trial_order.h"

namespace palpate::experiment {

enum class RunState : std::uint8_t { trial, rest, finished };

class ExperimentRun {
 public:
  ExperimentRun(Conditions conditions, std::uint64_t seed);
  ExperimentRun(const ExperimentRun&) = delete;
  ExperimentRun& operator=(const ExperimentRun&) = delete;

  RunState state() const { return state_; }
  const Trial& next_trial() const;
  TrialRecord answer(const Answer& answer);
  void end_rest();

  // Takes up a run after these answers. Refused where one of them is not to the trial that conditions and seed give: `source`
  // names where they are from.
  Expected<void> take_up(std::span<const TrialRecord> records, std::string_view source);

  const Conditions& conditions() const { return conditions_; }
  std::uint64_t seed() const { return seed_; }
  // The levels of a trial's cell, in the factors' order; one by its factor's name (std::out_of_range: there is none).
  const std::vector<std::string>& levels_of(const Trial& trial) const { return cells_.at(trial.cell); }
  const std::string& level_of(const Trial& trial, std::string_view factor) const;
  int answered() const { return answered_; }  // practice included
  // Of all, practice included; what staircases do not need is left over.
  int most_trials() const { return most_; }
  // Of staircases: a cell's tracks after each other, cells in the order of cells_of().
  const std::vector<Staircase>& staircases() const;

 private:
  void advance();
  std::optional<Trial> upcoming();
  Trial of_staircase();

  Conditions conditions_;
  std::uint64_t seed_;
  std::vector<std::vector<std::string>> cells_;
  Random places_random_;
  std::deque<Trial> planned_;  // practice, constant stimuli, what comes again
  std::optional<InterleavedStaircases> staircases_;
  std::vector<BalancedPlaces> track_places_;
  Trial next_;
  RunState state_ = RunState::trial;
  int answered_ = 0, since_rest_ = 0, most_ = 0;
};

}  // namespace palpate::experiment
