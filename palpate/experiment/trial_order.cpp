#include "palpate/experiment/trial_order.h"

#include "palpate/experiment/shuffle.h"

namespace palpate::experiment {

int BalancedPlaces::next() {
  if (left_.empty()) {
    for (int place = 1; place <= places_; ++place) left_.push_back(place);
    shuffle(left_, *random_);
  }
  const int place = left_.back();
  left_.pop_back();
  return place;
}

std::vector<Trial> constant_trials(const Conditions& conditions, std::uint64_t seed) {
  Random order(seed, "experiment/order"), where(seed, "experiment/place");
  const std::size_t cells = cells_of(conditions).size(), levels = conditions.levels.size();
  std::vector<BalancedPlaces> places(cells * levels, BalancedPlaces(conditions.places, where));
  std::vector<Trial> trials;
  for (int block = 1; block <= conditions.repeats; ++block) {
    std::vector<Trial> these;
    for (std::size_t cell = 0; cell < cells; ++cell)
      for (std::size_t level = 0; level < levels; ++level)
        these.push_back({.block = block,
                         .cell = cell,
                         .stimulus = conditions.levels[level],
                         .target = places[cell * levels + level].next()});
    shuffle(these, order);
    trials.insert(trials.end(), these.begin(), these.end());
  }
  return trials;
}

std::vector<Trial> practice_trials(const Conditions& conditions, std::uint64_t seed) {
  Random random(seed, "experiment/practice");
  const std::size_t cells = cells_of(conditions).size();
  BalancedPlaces places(conditions.places, random);
  std::vector<Trial> trials;
  std::vector<std::size_t> cell;
  std::vector<double> stimuli;
  for (int i = 0; i < conditions.practice; ++i) {
    if (cell.empty()) {
      for (std::size_t c = 0; c < cells; ++c) cell.push_back(c);
      shuffle(cell, random);
    }
    if (stimuli.empty()) {
      stimuli = conditions.levels;
      if (conditions.method == Method::staircase) stimuli = {conditions.rule.start};
      shuffle(stimuli, random);
    }
    trials.push_back(
        {.practice = true, .cell = cell.back(), .stimulus = stimuli.back(), .target = places.next()});
    cell.pop_back();
    stimuli.pop_back();
  }
  return trials;
}

}  // namespace palpate::experiment
