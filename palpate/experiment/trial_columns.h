// The columns of a file of trials, in their order; a column for each factor comes after them.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace palpate::experiment {

inline constexpr std::array<std::string_view, 13> kTrialColumns{
    "trial",     // from 1
    "practice",  // 1: does not count
    "block",     // of constant stimuli, from 1; 0 in practice and of staircases
    "track",     // of staircases, from 1; 0 of constant stimuli
    "repeated",  // how often this trial was left out before
    "stimulus",
    "target",      // the place that has the stimulus, from 1
    "answer",      // the place that was taken; 1 yes, 2 no; 0 none
    "response",    // 1: positive
    "response_s",  // how long the answer took
    "time_s",      // when it came, since the run's beginning
    "excluded",    // 1: left out of the fits
    "why",         // of what is left out
};

// Of this file, or of others with counts in place of single trials.
inline bool is_trial_column(std::string_view name) {
  return std::find(kTrialColumns.begin(), kTrialColumns.end(), name) != kTrialColumns.end() ||
         name == "positives" || name == "trials";
}

}  // namespace palpate::experiment
