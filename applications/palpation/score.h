// What marks are worth beside the truth. Frame Body, m. Pure; no allocation.
#pragma once

#include <array>
#include <limits>
#include <span>

#include "applications/palpation/nodules.h"

namespace palpate::applications::palpation {

inline constexpr std::size_t kMostMarks = 5, kMostNodules = 3;

struct Score {
  int nodules = 0, found = 0, false_alarms = 0;
  // m, along the surface's chord from each nodule found to its mark; no number where it was missed.
  std::array<double, kMostNodules> error{};
  int missed() const { return nodules - found; }
  // The median of those found, the mean of the middle two; no number for none.
  double median_error() const;
};

// A mark has found a nodule where it lies within `within` of the surface above it; each finds one at most, the nearest
// pairs first. At most kMostNodules and kMostMarks count.
Score score_of(std::span<const HiddenNodule> nodules, std::span<const Vector3> marks, double within);

}  // namespace palpate::applications::palpation
