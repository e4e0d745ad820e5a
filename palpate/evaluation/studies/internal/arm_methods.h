// The methods that the arm's studies set beside one another, by the names that files and pages show.
//
// All of them begin at gains 1 and offsets 0. The paper's three free gains, offsets and - as in its equation
// 8 - the arm's lengths, and take the tip from the pivot calibration. Ours frees gains, offsets and the tip,
// and holds the lengths at the maker's values unless asked for them. Pure functions, any thread.
#pragma once

#include <string_view>

#include "palpate/calibration/arm.h"
#include "palpate/evaluation/studies/internal/arm_laboratory.h"

namespace palpate::evaluation::studies {

inline constexpr std::string_view kUncorrected = "uncorrected";
inline constexpr std::string_view kOnePass = "paper: one pass";
inline constexpr std::string_view kAlternating = "paper: alternating";
inline constexpr std::string_view kEq7 = "paper: equations 7, 8";
inline constexpr std::string_view kJoint = "ours: joint with tip";
// Two more curves: what the tracker itself errs by, and what no unbiased method can be better than.
inline constexpr std::string_view kNoiseFloor = "noise floor (true parameters)";
inline constexpr std::string_view kBound = "Cramer-Rao bound";

enum class Lengths { as_the_method_has_them, held, free };

struct MethodChoice {
  Lengths lengths = Lengths::as_the_method_has_them;
  bool free_gains = true;
  // The covariance allows for the tracker's systematic error; costs about as much as the solve.
  bool full_covariance = false;
};

// The tip is that of the laboratory's pivot calibration.
Expected<Estimate<calibration::ArmSolution>> solve_as(std::string_view method,
                                                      const std::vector<device::ArmObservation>& samples,
                                                      const device::ArmModel& nominal, const Vector3& tip,
                                                      const MethodChoice& choice = {});

}  // namespace palpate::evaluation::studies
