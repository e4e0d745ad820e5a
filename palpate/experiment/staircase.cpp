#include "palpate/experiment/staircase.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "palpate/experiment/shuffle.h"

namespace palpate::experiment {

std::optional<RuleComplaint> complaint_of(const StaircaseRule& rule) {
  const auto outside = [](double x, double low, double high) { return !(x >= low && x <= high); };
  if (rule.kind == StaircaseKind::transformed && (rule.down_after < 1 || rule.down_after > 10))
    return RuleComplaint{"down_after", fmt::format("is {}, 1 to 10 is expected", rule.down_after)};
  if (rule.kind == StaircaseKind::weighted && outside(rule.target, 0.05, 0.95))
    return RuleComplaint{"target", fmt::format("is {}, 0.05 to 0.95 is expected", rule.target)};
  if (!(rule.lowest > 0.0))
    return RuleComplaint{"lowest", fmt::format("is {}, above 0 is expected", rule.lowest)};
  if (!(rule.highest > rule.lowest) || !std::isfinite(rule.highest))
    return RuleComplaint{"highest",
                         fmt::format("is {}, above lowest ({}) is expected", rule.highest, rule.lowest)};
  if (outside(rule.start, rule.lowest, rule.highest))
    return RuleComplaint{"start", fmt::format("is {}, lowest to highest ({} to {}) is expected", rule.start,
                                              rule.lowest, rule.highest)};
  if (rule.step_factors.empty())
    return RuleComplaint{"step_factors", "is empty, one factor or more is expected"};
  for (const double factor : rule.step_factors)
    if (!(factor > 1.0) || outside(factor, 1.0, 100.0))
      return RuleComplaint{"step_factors",
                           fmt::format("holds {}, factors above 1 and up to 100 are expected", factor)};
  if (outside(rule.reversals, 2, 1000))
    return RuleComplaint{"reversals", fmt::format("is {}, 2 to 1000 is expected", rule.reversals)};
  if (rule.discard < 0 || rule.discard > rule.reversals - 2)
    return RuleComplaint{"discard", fmt::format("is {}; of {} reversals two or more must be left",
                                                rule.discard, rule.reversals)};
  if (outside(rule.most_trials, 2, 100'000))
    return RuleComplaint{"most_trials", fmt::format("is {}, 2 to 100000 is expected", rule.most_trials)};
  return std::nullopt;
}

double share_sought(const StaircaseRule& rule) {
  return rule.kind == StaircaseKind::weighted ? rule.target : std::pow(0.5, 1.0 / rule.down_after);
}

Staircase::Staircase(StaircaseRule rule) : rule_(std::move(rule)), stimulus_(rule_.start) {
  if (const auto wrong = complaint_of(rule_))
    throw std::invalid_argument(fmt::format("staircase: {} {}", wrong->key, wrong->message));
}

bool Staircase::finished() const {
  return trials_ >= rule_.most_trials || static_cast<int>(reversals_.size()) >= rule_.reversals;
}

void Staircase::pass() {
  if (finished()) throw std::logic_error("staircase: an answer after its end");
  ++trials_;
}

void Staircase::answer(bool positive) {
  pass();
  if (stimulus_ <= rule_.lowest || stimulus_ >= rule_.highest) ++trials_at_limit_;
  if (!positive) {
    in_a_row_ = 0;
    move(+1);
  } else if (++in_a_row_ >= (rule_.kind == StaircaseKind::transformed ? rule_.down_after : 1)) {
    in_a_row_ = 0;
    move(-1);
  }
}

void Staircase::move(int direction) {
  if (direction_ != 0 && direction != direction_) reversals_.push_back(stimulus_);
  direction_ = direction;
  const double down =
      std::log(rule_.step_factors[std::min(reversals_.size(), rule_.step_factors.size() - 1)]);
  // Where the two balance, share x down = (1 - share) x up.
  const double up = rule_.kind == StaircaseKind::weighted ? down * rule_.target / (1.0 - rule_.target) : down;
  stimulus_ = std::clamp(stimulus_ * std::exp(direction > 0 ? up : -down), rule_.lowest, rule_.highest);
}

std::optional<StaircaseThreshold> Staircase::threshold() const {
  std::size_t counted =
      reversals_.size() - std::min(reversals_.size(), static_cast<std::size_t>(rule_.discard));
  counted -= counted % 2;
  if (counted < 2) return std::nullopt;
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = reversals_.size() - counted; i < reversals_.size(); ++i) {
    const double x = std::log(reversals_[i]);
    sum += x;
    squares += x * x;
  }
  const double n = static_cast<double>(counted), mean = sum / n;
  return StaircaseThreshold{std::exp(mean), std::sqrt(std::max(0.0, (squares - n * mean * mean) / (n - 1.0))),
                            static_cast<int>(counted)};
}

InterleavedStaircases::InterleavedStaircases(std::vector<StaircaseRule> rules, std::uint64_t seed)
    : random_(seed, "experiment/interleaved") {
  if (rules.empty()) throw std::invalid_argument("interleaved staircases: one or more are expected");
  for (auto& rule : rules) all_.emplace_back(std::move(rule));
  begin_round();
}

void InterleavedStaircases::begin_round() {
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (!all_[i].finished()) round_.push_back(i);
  shuffle(round_, random_);
}

bool InterleavedStaircases::finished() const { return round_.empty(); }

std::size_t InterleavedStaircases::next() const {
  if (round_.empty()) throw std::logic_error("interleaved staircases: all are finished");
  return round_.back();
}

void InterleavedStaircases::answer(std::optional<bool> positive) {
  const std::size_t whose = next();
  if (positive)
    all_[whose].answer(*positive);
  else
    all_[whose].pass();
  round_.pop_back();
  if (round_.empty()) begin_round();
}

}  // namespace palpate::experiment
