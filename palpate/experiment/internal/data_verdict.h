// Whether answers tell a psychometric function: of their counts alone, and of the likeliest curve. Pure, any thread.
#pragma once

#include <span>

#include "palpate/experiment/internal/likelihood_search.h"
#include "palpate/experiment/psychometric_fit.h"

namespace palpate::experiment {

// Levels rise and have trials.
DataVerdict judge_counts(std::span<const Level> levels);
// Where the counts are usable.
DataVerdict judge_curve(std::span<const Level> levels, const SearchBounds& bounds, const SearchResult& found);

}  // namespace palpate::experiment
