// An order drawn by lot, the same on every machine (Fisher and Yates; Durstenfeld 1964). std::shuffle differs between
// libraries.
#pragma once

#include <utility>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::experiment {

template <typename T>
void shuffle(std::vector<T>& values, Random& random) {
  for (std::size_t i = values.size(); i > 1; --i) {
    const auto j = static_cast<std::size_t>(random.below(i));
    std::swap(values[i - 1], values[j]);
  }
}

}  // namespace palpate::experiment
