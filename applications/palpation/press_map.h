// What a trainee makes of presses at places of a grid: where it feels harder than around.
//
// Logarithms of forces at equal depth, averaged over the presses of a place. What changes slowly over the organ (its
// thickness and curvature) is taken out by a smooth trend, a polynomial of plan coordinates fitted to all places but
// those that stand out; what is left above it is hardness. Metres in the plan (x, z). Values; one thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "applications/palpation/nodule_odds.h"

namespace palpate::applications::palpation {

// Places of a grid of this spacing on an ellipse around `centre`, row by row, to and fro.
std::vector<PlanPlace> grid_of(const PlanPlace& centre, const PlanPlace& half, double spacing);

class PressMap {
 public:
  enum class Trend { level, quadratic };

  // `noise`: of the logarithm of a single press.
  PressMap(std::vector<PlanPlace> places, double spacing, double noise, Trend trend);

  // A further place, and its number.
  std::size_t add_place(const PlanPlace& place);
  void felt(std::size_t place, double log_force);

  const std::vector<PlanPlace>& places() const { return places_; }
  std::size_t presses(std::size_t place) const { return count_[place]; }
  // Above the trend, of each place; 0 where it has not been pressed.
  std::vector<double> hardness() const;
  // The hardest first.
  std::vector<std::size_t> best(std::size_t count) const;
  // Where a nodule is likeliest, the likeliest first, further apart than `apart`: places of a fine net on and about those
  // pressed, by how well a nodule there explains what has been felt around it (nodule_odds.h).
  std::vector<PlanPlace> likeliest(std::size_t count, double apart) const;
  // Where it believes nodules to be: the likeliest places, as many as are surely felt, at least `fewest` and at most `most`.
  std::vector<PlanPlace> believed(std::size_t fewest, std::size_t most, double apart) const;

 private:
  NoduleOdds weigh() const;
  double mean(std::size_t place) const { return sum_[place] / static_cast<double>(count_[place]); }

  std::vector<PlanPlace> places_;
  double spacing_, noise_;
  Trend trend_;
  std::vector<double> sum_;
  std::vector<std::size_t> count_;
};

}  // namespace palpate::applications::palpation
