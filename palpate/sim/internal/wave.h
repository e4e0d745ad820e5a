#pragma once
// A sine of a person's slow movements, in one place.

#include <cmath>
#include <numbers>

namespace palpate::sim {

inline double wave(double hz, double t, double phase = 0.0) {
  return std::sin(2.0 * std::numbers::pi * hz * t + phase);
}

}  // namespace palpate::sim
