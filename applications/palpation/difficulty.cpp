#include "applications/palpation/difficulty.h"

#include <algorithm>
#include <cmath>

namespace palpate::applications::palpation {
namespace {

// A level as the staircase has it: of its stimuli the larger one is the easier one, and its steps are factors.
constexpr double kLogOfLevel = 0.1;

double stimulus_of(int level) { return std::exp(kLogOfLevel * (kHardestLevel - level)); }

experiment::StaircaseRule rule_from(int start) {
  experiment::StaircaseRule rule;
  rule.kind = experiment::StaircaseKind::transformed;
  rule.down_after = 2;
  rule.start = stimulus_of(std::clamp(start, 0, kHardestLevel));
  rule.lowest = stimulus_of(kHardestLevel);
  rule.highest = stimulus_of(0);
  rule.step_factors = {std::exp(2.0 * kLogOfLevel), std::exp(kLogOfLevel)};
  // It has no end but the session's: these are the most that a rule may say.
  rule.reversals = 1000;
  rule.most_trials = 100'000;
  return rule;
}

}  // namespace

NoduleRanges ranges_at(const NoduleRanges& scale, int level) {
  const double hard = static_cast<double>(std::clamp(level, 0, kHardestLevel)) / kHardestLevel;
  const double diameter = std::lerp(scale.diameter[1], scale.diameter[0], hard);
  const double depth = std::lerp(scale.depth[0], scale.depth[1], hard);
  NoduleRanges ranges = scale;
  ranges.diameter = {diameter, diameter};
  ranges.depth = {depth, depth};
  return ranges;
}

DifficultyStaircase::DifficultyStaircase(int start) : staircase_(rule_from(start)) {}

int DifficultyStaircase::level() const {
  return kHardestLevel - static_cast<int>(std::lround(std::log(staircase_.stimulus()) / kLogOfLevel));
}

void DifficultyStaircase::answer(bool positive) {
  if (!staircase_.finished()) staircase_.answer(positive);
}

}  // namespace palpate::applications::palpation
