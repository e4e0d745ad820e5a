// One search for nodules after the other: when it begins and ends, where the trainee has marked, what it took.
//
//   ready -- a new touch --> searching -- time over, put away, or asked --> shown -- asked, or a pause --> ready
// A tip that rests on the organ from before has to be lifted first: what it touched belongs to the trial before, or to
// another hand that has been relieved.
// A place is marked by pressing there and holding still for TrialRules::dwell_s, or by asking while the tip touches; a
// mark beside one that is there takes that back. A search ends when it is asked for away from the organ, when the tip has
// been put away (kAway_m above the organ, for kAway_s), or when its time is over. Frame Body, SI. One thread; nothing
// allocates.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "applications/palpation/score.h"
#include "applications/palpation/settings.h"

namespace palpate::applications::palpation {

enum class TrialPhase : std::int32_t { ready, searching, shown };

// What the trial has to know of the tip in each step.
struct TipOnOrgan {
  bool seen = false;                // its place is known
  Vector3 tip = Vector3::Zero();    // the sphere's centre
  Vector3 foot = Vector3::Zero();   // while it touches, the surface's point at rest that it presses
  double depth = 0.0, force = 0.0;  // m, N; depth 0: it does not touch
};

class Trial {
 public:
  static constexpr double kAway_m = 0.050, kAway_s = 0.8;

  // `top`: the organ's highest place.
  Trial(const TrialRules& rules, double top) : rules_(rules), top_(top) {}

  // The next one, with these in the organ; they must outlive it.
  void prepare(std::span<const HiddenNodule> nodules);
  void step(double dt, const TipOnOrgan& tip);
  // A person's wish, as above; while shown, for the next trial.
  void ask();

  TrialPhase phase() const { return phase_; }
  bool next_wanted() const { return next_wanted_; }  // shown long enough: whoever prepares may do so
  std::span<const Vector3> marks() const { return {marks_.data(), mark_count_}; }
  double dwelt() const { return dwelt_ / rules_.dwell_s; }  // 0 to 1: how far a mark is
  double searched_s() const { return searched_; }
  double path() const { return path_; }  // m, of the tip while searching
  int hard_presses() const { return hard_; }
  const Score& score() const { return score_; }  // while shown

 private:
  void mark(const Vector3& foot);
  void dwell(double dt, const TipOnOrgan& tip);
  void end();

  TrialRules rules_;
  double top_;
  std::span<const HiddenNodule> nodules_;
  TrialPhase phase_ = TrialPhase::ready;
  bool next_wanted_ = false;
  bool lifted_ = false;  // since it was prepared
  TipOnOrgan now_;
  std::array<Vector3, kMostMarks> marks_{};
  std::size_t mark_count_ = 0;
  Vector3 rested_ = Vector3::Zero();  // where the tip came to rest
  double dwelt_ = 0.0;                // s
  bool marked_here_ = false;          // until it has moved on
  double searched_ = 0.0, path_ = 0.0, away_ = 0.0, shown_ = 0.0;
  int hard_ = 0;
  bool pressing_hard_ = false;
  Score score_;
};

}  // namespace palpate::applications::palpation
