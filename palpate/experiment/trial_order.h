// The order of an experiment's trials, drawn by lot and balanced.
//
// Constant stimuli come in blocks, each of which has every stimulus of every cell once, in an order of its own: practice and
// fatigue fall on all alike. The place of the stimulus is balanced, too: of as many repeats as there are places it is once at
// each. The same seed gives the same order on every machine. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/experiment/conditions.h"
#include "palpate/experiment/trial.h"

namespace palpate::experiment {

// Places of the stimulus, balanced over as many trials as there are places.
class BalancedPlaces {
 public:
  BalancedPlaces(int places, Random& random) : places_(places), random_(&random) {}
  int next();

 private:
  int places_;
  Random* random_;
  std::vector<int> left_;
};

// Numbers are not given yet.
std::vector<Trial> constant_trials(const Conditions& conditions, std::uint64_t seed);
// Trials of all cells in turn, with any of the stimuli; of staircases with the first one.
std::vector<Trial> practice_trials(const Conditions& conditions, std::uint64_t seed);

}  // namespace palpate::experiment
