// Inside of the study of Figures 7, 8 and 9: its four experiments and what its page draws. Internal to this
// module. Each experiment adds its curves, key figures and lines; refused where no laboratory can be
// recorded.
#pragma once

#include <array>

#include "palpate/evaluation/studies/internal/arm_methods.h"
#include "palpate/evaluation/studies/study.h"

namespace palpate::evaluation::studies {

inline constexpr std::array kPointCounts{5, 7, 10, 15, 20, 30, 50, 70, 100, 140};
inline constexpr int kHalf = 70;  // the paper's training set

// Runs that share a laboratory: 1000 runs are 200 draws of the world.
inline constexpr std::size_t kRunsPerLaboratory = 5;

// White noise alone, a laboratory for each run: where ours is set against the bound.
inline constexpr std::array kWhiteCounts{10, 15, 30, 70, 140};
struct BoundBar {
  int points;
  double most;  // of our rms over the bound's
};
inline constexpr std::array<BoundBar, 4> kBoundBars{{{15, 1.3}, {30, 1.1}, {70, 1.1}, {140, 1.1}}};

// Where stated 95 % regions are put to the test. (With the bias on, up to the paper's half.)
inline constexpr std::array kCoverageCounts{15, 30, 70, 140};

// Where lengths are freed or held and gains are held, to see what that does.
inline constexpr int kVariantCount = 70;

// Figure 7: random halves, as in the paper, over many laboratories.
Expected<void> add_splits(StudyResult& study, const StudyOptions& options);
// The bound, and whether stated regions hold the truth.
Expected<void> add_bound(StudyResult& study, const StudyOptions& options);
// What 5 % of wild poses do.
Expected<void> add_outliers(StudyResult& study, const StudyOptions& options);
// Figures 8 and 9: the numbers found on one arm.
Expected<void> add_one_arm(StudyResult& study, const StudyOptions& options);

// From the study's curves and values: by_points, paper_best_mm, floor_excess, and the rows of cramer_rao, coverage and
// outliers with their verdicts.
Expected<Json> points_page(const StudyResult& study);

}  // namespace palpate::evaluation::studies
