#include "palpate/experiment/observer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "palpate/experiment/psychometric.h"

namespace palpate::experiment {

Cue mixed(std::span<const Cue> cues) {
  double weights = 0.0, sum = 0.0;
  for (const auto& cue : cues) {
    if (!(cue.log_sd > 0.0)) throw std::invalid_argument("cues: a noise above 0 is expected");
    const double weight = 1.0 / (cue.log_sd * cue.log_sd);
    weights += weight;
    sum += weight * cue.log_value;
  }
  if (cues.empty()) throw std::invalid_argument("cues: one or more are expected");
  return {sum / weights, 1.0 / std::sqrt(weights)};
}

double noise_of_weber_fraction(double fraction) {
  return spread_of_weber_fraction(fraction) / std::numbers::sqrt2;
}

double practised_weber_fraction(int sessions) {
  constexpr double kBefore = 0.28, kAfter = 0.14;
  constexpr int kSessions = 6;
  return kBefore *
         std::pow(kAfter / kBefore, std::clamp(sessions, 0, kSessions) / static_cast<double>(kSessions));
}

Observer::Observer(const ObserverModel& model, std::uint64_t seed)
    : noise_(noise_of_weber_fraction(model.weber_fraction)),
      lapse_rate_(model.lapse_rate),
      random_(seed, "experiment/observer") {
  if (!(model.weber_fraction > 0.0) || !(model.lapse_rate >= 0.0 && model.lapse_rate <= 1.0))
    throw std::invalid_argument("observer: a Weber fraction above 0 and a lapse rate of 0 to 1 are expected");
}

double Observer::perceived(double quantity) { return std::log(quantity) + random_.normal(noise_); }

double Observer::perceived(std::span<const Cue> cues) {
  std::vector<Cue> noisy(cues.begin(), cues.end());
  for (auto& cue : noisy) cue.log_value += random_.normal(cue.log_sd);
  return mixed(noisy).log_value;
}

std::size_t Observer::largest(std::span<const double> quantities) {
  if (quantities.empty()) throw std::invalid_argument("observer: one quantity or more is expected");
  std::vector<double> perceptions;
  for (const double quantity : quantities) perceptions.push_back(perceived(quantity));
  if (random_.chance(lapse_rate_)) return static_cast<std::size_t>(random_.below(quantities.size()));
  return static_cast<std::size_t>(std::max_element(perceptions.begin(), perceptions.end()) -
                                  perceptions.begin());
}

bool Observer::is_above(double quantity, double criterion) {
  const bool above = perceived(quantity) > std::log(criterion);
  return random_.chance(lapse_rate_) ? random_.chance(0.5) : above;
}

}  // namespace palpate::experiment
