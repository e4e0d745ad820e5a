// What the scripted trainee makes of one press: how stiff it takes the place for.
//
// It pairs what it feels with how deep its hand is and with how deep it sees the tip, moment by moment on the way in, and
// takes from each pair the stiffness k of f = k d^1.5 by least squares. The two estimates are mixed by their reliabilities
// (Ernst, Banks 2002), in logarithms. Nothing here knows of the delays: force and picture come late or they do not, and
// what follows from it follows. Noise, all of the logarithm and drawn for each press: of the force, of the hand's and the
// eye's sense of depth (the exponent times as large in the stiffness), of remembering one press until the next.
//
// Sizes of the noise: docs/theory/trainee.md. SI. Values; TraineeSenses is of one thread and deterministic by seed.
#pragma once

#include <cstdint>
#include <vector>

#include "applications/palpation/block_forces.h"
#include "palpate/experiment/observer.h"

namespace palpate::applications::palpation {

// Of the logarithms: of force, memory, and of a depth felt by the hand and seen by the eye.
struct SenseNoise {
  double force = 0.0, memory = 0.0, hand = 0.0, eye = 0.0;
};

// Of a person whose Weber fraction for the compliance of a spring, pressed as deep as it likes without looking, is this:
// the published parts in proportion.
SenseNoise sense_noise(double weber_fraction);

// What comes late, s: the force beyond its tick, the picture beyond what a person sees late anyway.
struct AddedDelay {
  double force = 0.0, picture = 0.0;
};

struct PressMotion {
  double depth = kBlockPress_m;  // m, where the hand turns
  double inwards_s = 0.40;       // of least jerk from the first touch to there
  double picture_late_s = 0.10;  // what is seen is as old as that without any added delay
};

// What there is to a press, each millisecond of the way in.
struct PressFelt {
  std::vector<double> force;       // N, as commanded then
  std::vector<double> hand, seen;  // m, of the hand then and of the picture then
};
PressFelt felt_inwards(const ForceCurve& place, const PressMotion& motion, const AddedDelay& delay);

// ln k by least squares of force over depth^1.5; not a number where no depth is above 0.
double log_stiffness(const std::vector<double>& force, const std::vector<double>& depth);

struct Senses {
  bool force = true, sight = true;  // without force every place feels alike
};

class TraineeSenses {
 public:
  TraineeSenses(const SenseNoise& noise, std::uint64_t seed);

  // ln k of a place as it takes it.
  double judged(const PressFelt& felt, const Senses& senses);
  // Noise of one judgement, standard deviation, of a depth that is known but for hand and eye.
  static double total_noise(const SenseNoise& noise, bool sight);
  // How much of the judgement is the eye's, 0 to 1.
  static double eye_weight(const SenseNoise& noise);

 private:
  SenseNoise noise_;
  experiment::Observer depth_;  // draws of hand and eye
  Random force_, memory_;
};

}  // namespace palpate::applications::palpation
