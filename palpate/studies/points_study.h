// Inside of the study of Figures 7, 8 and 9: what is tried, and the page's part. Internal to this module.
#pragma once

#include <array>
#include <string_view>

#include "palpate/studies/study.h"

namespace palpate {

inline constexpr std::array kPointCounts{5, 7, 10, 15, 20, 30, 50, 70, 100, 140};
inline constexpr std::array kBoundCounts{15, 30, 70, 140};  // where our rms is set against the bound's

// Runs that share a laboratory: 1000 runs are 200 draws of the world.
inline constexpr std::size_t kRunsPerLaboratory = 5;

// Names of methods and curves, as in files and page.
inline constexpr std::string_view kUncorrected = "uncorrected";
inline constexpr std::string_view kOnePass = "paper: one pass";
inline constexpr std::string_view kAlternating = "paper: alternating";
inline constexpr std::string_view kEq7 = "paper: equations 7, 8";
inline constexpr std::string_view kJoint = "ours: joint with tip";
inline constexpr std::string_view kBound = "Cramer-Rao bound";

void tell_points(report::Report& page, const StudyResult& study);

}  // namespace palpate
