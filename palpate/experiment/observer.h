// A scripted observer: compares what it feels (and sees) with noise of a known size, so that tests and studies know what an
// experiment should find.
//
// Noise is of the logarithm, the same at every size (Weber's law): a comparison of two is right three times in four where
// the one is by the Weber fraction larger. Cues to one quantity are mixed by their reliabilities, which is the mixture of
// least variance (Ernst, Banks 2002). A lapse is an answer by lot. Quantities are above 0, in any unit, ratios alone count.
// Deterministic by seed; one thread. Wrong use (exception): a fraction not above 0, a lapse rate outside of 0 to 1, no cue.
//
// Sources: Ernst, Banks (2002), "Humans integrate visual and haptic information in a statistically optimal fashion"; Howell
// et al. (2008), "The Virtual Haptic Back: a simulation for training in palpatory diagnosis" (smallest difference of compliance
// told: 28 % before, 14 % after six sessions).
#pragma once

#include <cstdint>
#include <span>

#include "palpate/core/random.h"

namespace palpate::experiment {

// One sense's report of a quantity, as its logarithm.
struct Cue {
  double log_value = 0.0;
  double log_sd = 1.0;  // its noise
};

// What the cues say together: each weighed by the inverse of its variance.
Cue mixed(std::span<const Cue> cues);

// Noise of the logarithm of a single quantity for this Weber fraction: ln(1 + w) / (sqrt 2 x 0.674).
double noise_of_weber_fraction(double fraction);

// The Weber fraction after so many sessions of practice, 0 before the first: from 28 % to 14 % at the sixth, then steady.
// Only the two ends were published; between them a constant share of it is assumed to go with every session.
double practised_weber_fraction(int sessions);

struct ObserverModel {
  double weber_fraction = 0.14;
  double lapse_rate = 0.02;
};

class Observer {
 public:
  Observer(const ObserverModel& model, std::uint64_t seed);

  // What it takes a quantity for: its logarithm with noise.
  double perceived(double quantity);
  // The same of several cues, each with the noise it states.
  double perceived(std::span<const Cue> cues);

  // The largest of the quantities, as its place from 0; by lot where it lapses.
  std::size_t largest(std::span<const double> quantities);
  // Whether a quantity is above a criterion that is remembered without noise.
  bool is_above(double quantity, double criterion);

 private:
  double noise_, lapse_rate_;
  Random random_;
};

}  // namespace palpate::experiment
