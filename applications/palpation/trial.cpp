#include "applications/palpation/trial.h"

#include <algorithm>

namespace palpate::applications::palpation {
namespace {

constexpr double kFirm_m = 0.0015;      // a touch lighter than that is no pressing
constexpr double kStill_m = 0.0020;     // a hand that rests stays within
constexpr double kSame_m = 0.0050;      // a mark so near is the same place
constexpr double kLetUp = 0.8;          // of the force that is too hard: below it, another press begins
constexpr double kLongestWay_m = 0.02;  // in a step: further, and the tip was put there

}  // namespace

void Trial::prepare(std::span<const HiddenNodule> nodules) {
  const TrialRules rules = rules_;
  *this = Trial(rules, top_);
  nodules_ = nodules;
}

void Trial::end() {
  if (phase_ != TrialPhase::searching) return;
  phase_ = TrialPhase::shown;
  dwelt_ = 0.0;
  score_ = score_of(nodules_, marks(), rules_.within);
}

void Trial::mark(const Vector3& foot) {
  for (std::size_t i = 0; i < mark_count_; ++i)
    if ((marks_[i] - foot).norm() < kSame_m) {
      std::copy(marks_.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                marks_.begin() + static_cast<std::ptrdiff_t>(mark_count_),
                marks_.begin() + static_cast<std::ptrdiff_t>(i));
      --mark_count_;
      return;
    }
  if (mark_count_ < kMostMarks) marks_[mark_count_++] = foot;
}

void Trial::ask() {
  if (phase_ == TrialPhase::shown) next_wanted_ = true;
  if (phase_ != TrialPhase::searching) return;
  if (now_.seen && now_.depth > 0.0)
    mark(now_.foot);
  else
    end();
}

void Trial::dwell(double dt, const TipOnOrgan& tip) {
  if (tip.depth < kFirm_m || (tip.foot - rested_).norm() > kStill_m) {
    rested_ = tip.foot;
    dwelt_ = 0.0;
    marked_here_ = false;
    return;
  }
  if (marked_here_) return;
  dwelt_ += dt;
  if (dwelt_ < rules_.dwell_s) return;
  mark(tip.foot);
  dwelt_ = 0.0;
  marked_here_ = true;
}

void Trial::step(double dt, const TipOnOrgan& tip) {
  const TipOnOrgan before = now_;
  now_ = tip;
  const bool touches = tip.seen && tip.depth > 0.0;
  if (phase_ == TrialPhase::shown) {
    shown_ += dt;
    if (rules_.pause_s > 0.0 && shown_ >= rules_.pause_s) next_wanted_ = true;
    return;
  }
  if (phase_ == TrialPhase::ready) {
    lifted_ = lifted_ || !touches;
    if (!touches || !lifted_) return;
    phase_ = TrialPhase::searching;
  }
  searched_ += dt;
  if (const double way = (tip.tip - before.tip).norm(); tip.seen && before.seen && way < kLongestWay_m)
    path_ += way;
  const bool hard = touches && tip.force > (pressing_hard_ ? kLetUp : 1.0) * rules_.hard_n;
  hard_ += hard && !pressing_hard_;
  pressing_hard_ = hard;
  if (touches)
    dwell(dt, tip);
  else
    dwelt_ = 0.0, marked_here_ = false;
  const bool away = tip.seen && tip.tip.y() > top_ + kAway_m;
  away_ = away ? away_ + dt : 0.0;
  if (searched_ >= rules_.seconds || away_ >= kAway_s) end();
}

}  // namespace palpate::applications::palpation
