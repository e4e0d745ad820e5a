// A psychometric function: how often a person answers "yes", is right, or takes the comparison for the larger one, as the
// stimulus grows.
//
//   p(x) = guess + (1 - guess - lapse) Phi((ln x - ln threshold) / spread)
//
// A cumulative Gaussian of the logarithm of the stimulus, since what people tell apart is a ratio. The guess rate is the
// task's and known; the lapse rate (answers that have nothing to do with the stimulus) is unknown within a bound, and left
// out it would be taken for a shallow slope. Stimuli are above 0, in any unit; the spread has none. Values and pure
// functions, any thread.
//
// Source: Wichmann, Hill (2001), "The psychometric function: I. Fitting, sampling, and goodness of fit".
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace palpate::experiment {

enum class GuessRule : std::uint8_t {
  fixed,         // known beforehand: 1 / n of a choice among n
  equals_lapse,  // which of two is larger: whoever lapses is wrong at one end as often as at the other
};

struct TaskShape {
  GuessRule rule = GuessRule::fixed;
  double guess = 0.5;        // of GuessRule::fixed
  double most_lapse = 0.06;  // Wichmann and Hill's bound
};

struct PsychometricCurve {
  double threshold = 1.0;  // where Phi is a half, in the stimulus' unit
  double spread = 1.0;     // standard deviation along ln x
  double lapse = 0.0;
};

// Trials of one stimulus.
struct Level {
  double stimulus = 0.0;
  int positives = 0;  // of them "yes", right, "the comparison is larger"
  int trials = 0;
};

// A single trial.
struct Observation {
  double stimulus = 0.0;
  bool positive = false;
};

// Rising stimuli, each once.
std::vector<Level> levels_of(std::span<const Observation> observations);

// The chance of a positive answer, and of a negative one with digits of its own.
struct Chance {
  double positive = 0.0, negative = 0.0;
};
Chance chance_at(const PsychometricCurve& curve, const TaskShape& task, double stimulus);

// The stimulus of which this share of answers is positive; not a number where the curve does not come there.
double stimulus_at(const PsychometricCurve& curve, const TaskShape& task, double share);

// Twice the logarithm of how much likelier the data are by their own shares than by the curve. Infinite where the curve
// excludes what was seen.
double deviance(const PsychometricCurve& curve, const TaskShape& task, std::span<const Level> levels);

// The Weber fraction of whoever compares two with this spread: by how much, of the one, the other must be larger for three
// right answers in four.
double weber_fraction(double spread);
double spread_of_weber_fraction(double fraction);

}  // namespace palpate::experiment
