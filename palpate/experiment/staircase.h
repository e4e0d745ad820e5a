// Adaptive staircases: the stimulus of a trial follows from the answers before it, and closes in on the stimulus of which a
// known share of answers is positive.
//
// Transformed (Levitt): n positive answers in a row make it weaker, a negative one stronger, by equal steps; two of them
// close in on 70.7 %. Weighted (Kaernbach): every answer moves it, and the steps' ratio sets the share. Steps are of ln
// stimulus, stimuli are above 0, in any unit; a larger one is the easier one. The threshold is the mean of the last
// reversals' logarithms, an even number of them, so that peaks and valleys weigh the same. It lies beside the share sought by
// an amount that falls with the step: 0.02 at 85 % where the longer step is half the spread. Values; one thread.
// Wrong use (exception): a rule that check() complains of, an answer after the end.
//
// Sources: Levitt (1971), "Transformed up-down methods in psychoacoustics"; Kaernbach (1991), "Simple adaptive testing with
// the weighted up-down method".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::experiment {

enum class StaircaseKind : std::uint8_t { transformed, weighted };

struct StaircaseRule {
  StaircaseKind kind = StaircaseKind::transformed;
  int down_after = 2;    // of the transformed rule
  double target = 0.75;  // of the weighted rule: share of positive answers
  double start = 2.0;    // stimuli of the first trial, and the weakest and strongest there are
  double lowest = 1.001;
  double highest = 8.0;
  // Steps downwards as factors above 1: the first one up to the first reversal, the second one up to the second and so on;
  // the last one stays.
  std::vector<double> step_factors{1.5, 1.3, 1.15};
  int reversals = 10;     // it ends with so many, or
  int most_trials = 100;  // with so many trials
  int discard = 4;        // of the reversals, the first ones do not count
};

// What is wrong with a rule, as key and words; none where nothing is.
struct RuleComplaint {
  std::string key, message;
};
std::optional<RuleComplaint> complaint_of(const StaircaseRule& rule);

// The share of positive answers that a rule closes in on.
double share_sought(const StaircaseRule& rule);

struct StaircaseThreshold {
  double stimulus = 0.0;
  double log_sd =
      0.0;  // scatter of the reversals' logarithms; they depend on each other, so it is no error of the mean
  int reversals = 0;
};

class Staircase {
 public:
  explicit Staircase(StaircaseRule rule);

  bool finished() const;
  double stimulus() const { return stimulus_; }  // of the next trial
  void answer(bool positive);
  void pass();  // a trial without an answer: it is counted, and the stimulus stays

  int trials() const { return trials_; }
  int trials_at_limit() const {
    return trials_at_limit_;
  }  // with the weakest or the strongest stimulus there is
  const std::vector<double>& reversals() const {
    return reversals_;
  }  // stimuli at which the direction turned
  // None with fewer than two reversals that count.
  std::optional<StaircaseThreshold> threshold() const;

 private:
  void move(int direction);

  StaircaseRule rule_;
  double stimulus_;
  int trials_ = 0, trials_at_limit_ = 0, in_a_row_ = 0, direction_ = 0;
  std::vector<double> reversals_;
};

// Several at a time, in rounds: each that is not finished once a round, in an order that nobody can foresee.
class InterleavedStaircases {
 public:
  InterleavedStaircases(std::vector<StaircaseRule> rules, std::uint64_t seed);

  bool finished() const;
  std::size_t next() const;  // whose turn it is
  double stimulus() const { return all_[next()].stimulus(); }
  // Of the one whose turn it is; without an answer it passes.
  void answer(std::optional<bool> positive);
  const std::vector<Staircase>& all() const { return all_; }

 private:
  void begin_round();

  std::vector<Staircase> all_;
  Random random_;
  std::vector<std::size_t> round_;  // what is left of it, the next one last
};

}  // namespace palpate::experiment
