// The psychometric function most likely to have given the answers seen, and how far it can be trusted.
//
// Maximum likelihood over threshold, spread and lapse rate: Fisher scoring, which is the house's Levenberg-Marquardt on the
// deviance, from the best places of a coarse grid. The lapse rate keeps to its bounds. Intervals of threshold and spread are
// by profile likelihood: all values that a ratio test at this level lets pass, the others fitted anew. Deterministic; pure
// functions, any thread.
//
// Errors: refused where the answers say nothing of the curve; judge() tells why as a code. Wrong use (exception) for a
// stimulus that is not above 0, for more positives than trials, and for a task whose rates leave no room.
//
// Sources: Wichmann, Hill (2001), I; Prins, Kingdom (2018), "Applying the model-comparison approach to test specific research
// hypotheses in psychophysical research using the Palamedes toolbox".
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/experiment/psychometric.h"

namespace palpate::experiment {

// Whether answers tell threshold and spread.
enum class DataVerdict : std::uint8_t {
  usable,
  no_trials,
  one_level,
  all_positive,
  all_negative,
  no_rise,    // answers do not follow the stimulus beyond what chance does
  separated,  // the curve rises between two neighbouring levels: its spread can be anything that fits between
  out_of_range,  // the threshold lies farther outside of the levels than they span
};
std::string_view name_of(DataVerdict verdict);

struct Interval {
  double low = 0.0, high = 0.0;
  bool low_open = false,
       high_open = false;  // the data do not bound it on this side; the end is where the search ended
};

struct PsychometricFit {
  PsychometricCurve curve;
  double log_threshold_sd = 0.0;  // from the information, the lapse rate being unknown, too
  double log_spread_sd = 0.0;
  Interval threshold, spread;  // by profile, at the level asked for
  double deviance = 0.0;
  int levels = 0, trials = 0;
  bool lapse_at_bound = false;
};

inline constexpr double kUsualLevel = 0.95;

DataVerdict judge(std::span<const Level> levels, const TaskShape& task);
Expected<PsychometricFit> fit_psychometric(std::span<const Level> levels, const TaskShape& task,
                                           double level = kUsualLevel);

// The curve alone, whatever it is worth: where the data bound nothing, it lies where the search ended.
PsychometricCurve most_likely_curve(std::span<const Level> levels, const TaskShape& task);

}  // namespace palpate::experiment
