#include "applications/palpation/press_judgement.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::applications::palpation {
namespace {

constexpr double kJudgedExponent = 1.5;  // Hertz's, which the trainee has learnt of soft matter
constexpr double kFeltEvery_s = 1e-3;

// Published Weber fractions, each the root of a sum of parts: of force; of stiffness pressed always as deep, which adds the
// memory of a press; pressed as deep as one likes, which adds the hand's depth.
constexpr double kForceWeber = 0.07, kFixedDepthWeber = 0.08, kFreeDepthWeber = 0.22;
// Thresholds of height by eye and by hand (Ernst, Banks 2002).
constexpr double kEyeToHand = 0.04 / 0.085;

// Least jerk from 0 to 1.
double least_jerk(double share) {
  const double u = std::clamp(share, 0.0, 1.0);
  return u * u * u * (10.0 + u * (6.0 * u - 15.0));
}

}  // namespace

SenseNoise sense_noise(double weber_fraction) {
  const auto square = [](double x) { return x * x; };
  const double force = square(experiment::noise_of_weber_fraction(kForceWeber)),
               fixed = square(experiment::noise_of_weber_fraction(kFixedDepthWeber)),
               free = square(experiment::noise_of_weber_fraction(kFreeDepthWeber));
  const double scale = square(experiment::noise_of_weber_fraction(weber_fraction)) / free;
  const double hand = std::sqrt(scale * (free - fixed));
  return {std::sqrt(scale * force), std::sqrt(scale * (fixed - force)), hand, kEyeToHand * hand};
}

PressFelt felt_inwards(const ForceCurve& place, const PressMotion& motion, const AddedDelay& delay) {
  const auto depth_at = [&](double t) { return motion.depth * least_jerk(t / motion.inwards_s); };
  PressFelt felt;
  const int ticks = static_cast<int>(std::lround(motion.inwards_s / kFeltEvery_s));
  for (int i = 1; i <= ticks; ++i) {
    const double t = i * kFeltEvery_s;
    felt.hand.push_back(depth_at(t));
    felt.seen.push_back(depth_at(t - motion.picture_late_s - delay.picture));
    felt.force.push_back(place.at(depth_at(t - kFeltEvery_s - delay.force)));
  }
  return felt;
}

double log_stiffness(const std::vector<double>& force, const std::vector<double>& depth) {
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    const double reference = std::pow(std::max(0.0, depth[i]), kJudgedExponent);
    product += force[i] * reference;
    square += reference * reference;
  }
  return square > 0.0 && product > 0.0 ? std::log(product / square)
                                       : std::numeric_limits<double>::quiet_NaN();
}

TraineeSenses::TraineeSenses(const SenseNoise& noise, std::uint64_t seed)
    : noise_(noise),
      depth_({.weber_fraction = 1.0, .lapse_rate = 0.0}, seed),
      force_(seed, "palpation/force sense"),
      memory_(seed, "palpation/memory") {}

double TraineeSenses::judged(const PressFelt& felt, const Senses& senses) {
  std::vector<double> force = felt.force;
  if (!senses.force)
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = std::pow(felt.hand[i], kJudgedExponent);
  std::vector<experiment::Cue> cues{{log_stiffness(force, felt.hand), kJudgedExponent * noise_.hand}};
  // A picture so late that nothing is seen to give way tells nothing.
  if (const double seen = log_stiffness(force, felt.seen); senses.sight && std::isfinite(seen))
    cues.push_back({seen, kJudgedExponent * noise_.eye});
  const double stiffness = depth_.perceived(cues);
  const double by_force = force_.normal(noise_.force);
  return stiffness + by_force + memory_.normal(noise_.memory);
}

double TraineeSenses::total_noise(const SenseNoise& noise, bool sight) {
  std::vector<experiment::Cue> cues{{0.0, kJudgedExponent * noise.hand}};
  if (sight) cues.push_back({0.0, kJudgedExponent * noise.eye});
  const double depth = experiment::mixed(cues).log_sd;
  return std::sqrt(noise.force * noise.force + noise.memory * noise.memory + depth * depth);
}

double TraineeSenses::eye_weight(const SenseNoise& noise) {
  const double eye = 1.0 / (noise.eye * noise.eye), hand = 1.0 / (noise.hand * noise.hand);
  return eye / (eye + hand);
}

}  // namespace palpate::applications::palpation
