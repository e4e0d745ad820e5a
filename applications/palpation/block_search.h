// Searches for one nodule in a flat block: what share of them ends where it is.
//
// The searching grid of the reference table (docs/theory/trainee.md): 100 x 70 mm, a press every 10 mm, the best five again
// four times, and the hardest of these is the answer; nodules lie in the inner 80 % of the sides, and are found within 10 mm.
// Each press has the noise of the Weber fraction, its depth is prescribed. Beside it a freer search with as many presses:
// those after the grid go, five at a time, where a nodule is likeliest by then (PressMap::likeliest), and so does the answer.
// SI. Pure; the same seed gives the same shares.
#pragma once

#include <cstdint>

#include "applications/palpation/block_forces.h"

namespace palpate::applications::palpation {

struct SearchTask {
  double weber_fraction = 0.14;
  bool senses = true;  // false: every press feels alike but for the noise
  int searches = 4000;
  std::uint64_t seed = 1;
};

// Shares of all searches, 0 to 1.
double grid_share(const ContrastProfile& profile, const SearchTask& task);
double freer_share(const ContrastProfile& profile, const SearchTask& task);

}  // namespace palpate::applications::palpation
