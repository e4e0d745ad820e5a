// The search for the most likely psychometric function, with any of its parameters held. Pure, any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "palpate/experiment/psychometric.h"

namespace palpate::experiment {

// ln threshold, ln spread, lapse rate.
using Parameters = Eigen::Vector3d;
inline constexpr std::array<bool, 3> kAllFree{true, true, true};

PsychometricCurve curve_of(const Parameters& at);

// Where parameters may lie: beyond it data of these levels tell nothing.
struct SearchBounds {
  Parameters low, high;
};
SearchBounds bounds_of(std::span<const Level> levels, const TaskShape& task);

struct SearchResult {
  Parameters at = Parameters::Zero();
  double deviance = 0.0;
};

// From `start`; of what is not `free` it keeps the values.
SearchResult descend(std::span<const Level> levels, const TaskShape& task, const SearchBounds& bounds,
                     const Parameters& start, const std::array<bool, 3>& free);
// Fisher's, of all that the task leaves free. A lapse rate at its bound counts as free: its truth is mostly within.
Eigen::Matrix3d information_at(std::span<const Level> levels, const TaskShape& task, const Parameters& at);
// From so many of a grid's best places.
SearchResult search(std::span<const Level> levels, const TaskShape& task, const SearchBounds& bounds,
                    std::size_t descents = 3);

}  // namespace palpate::experiment
