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

namespace palpate::applications::palpation {

using PlanPlace = Eigen::Vector2d;

// Places of a grid of this spacing on an ellipse around `centre`, row by row, to and fro.
std::vector<PlanPlace> grid_of(const PlanPlace& centre, const PlanPlace& half, double spacing);

class PressMap {
 public:
  enum class Trend { level, quadratic };

  // `noise`: of the logarithm of a single press.
  PressMap(std::vector<PlanPlace> places, double spacing, double noise, Trend trend);

  void felt(std::size_t place, double log_force);

  const std::vector<PlanPlace>& places() const { return places_; }
  std::size_t presses(std::size_t place) const { return count_[place]; }
  // Above the trend, of each place; 0 where it has not been pressed.
  std::vector<double> hardness() const;
  // The hardest first.
  std::vector<std::size_t> best(std::size_t count) const;
  // Where it believes nodules to be: places that stand out from their neighbours, the hardest first, drawn towards hard
  // neighbours; as many as are surely felt, at least `fewest` and at most `most`, further apart than `apart`.
  std::vector<PlanPlace> believed(std::size_t fewest, std::size_t most, double apart) const;

 private:
  double mean(std::size_t place) const { return sum_[place] / static_cast<double>(count_[place]); }
  PlanPlace drawn_to_neighbours(std::size_t place, const std::vector<double>& hardness) const;

  std::vector<PlanPlace> places_;
  double spacing_, noise_;
  Trend trend_;
  std::vector<double> sum_;
  std::vector<std::size_t> count_;
};

}  // namespace palpate::applications::palpation
