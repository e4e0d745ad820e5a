// A device's clock over a recording of any length: the host's time of each of its stamps.
//
// ClockEstimator knows the last twelve seconds; what it says of an earlier stamp is carried back along a straight line, and the
// error of its drift grows with the distance. This keeps what the estimator believed every three seconds and asks, for a stamp, the
// belief whose window lies around it; between two beliefs the time is interpolated, so that it makes no steps. Nothing is different
// within the last six seconds. The smallest latency stays in it, as there. One thread; allocates.
#pragma once

#include <algorithm>
#include <vector>

#include "palpate/time/clock_model.h"

namespace palpate::inline time {

template <typename From, typename To>
class ClockHistory {
 public:
  // As ClockEstimator::add().
  bool add(Instant<From> stamp, Instant<To> received, Duration waited = Duration(0)) {
    const bool used = estimator_.add(stamp, received, waited);
    if (!used) return false;
    // A clock that was set back: what was believed of the same stamps before says nothing any more.
    if (stamp < newest_ - kSetBack) kept_.clear();
    newest_ = kept_.empty() ? stamp : std::max(newest_, stamp);
    if (kept_.empty() || newest_ - kept_.back().at >= kEvery) kept_.push_back({newest_, estimator_.model()});
    return true;
  }

  Instant<To> to(Instant<From> t) const {
    const auto model = estimator_.model();
    const Instant<From> wanted = t + kHalfWindow;
    if (kept_.empty() || wanted >= newest_) return model.to(t);
    const auto after = std::lower_bound(kept_.begin(), kept_.end(), wanted,
                                        [](const Kept& kept, Instant<From> when) { return kept.at < when; });
    if (after == kept_.begin()) return after->model.to(t);
    const Kept& before = *(after - 1);
    const Kept next = after == kept_.end() ? Kept{newest_, model} : *after;
    const double s = to_seconds(wanted - before.at) / to_seconds(next.at - before.at);
    const Instant<To> a = before.model.to(t), b = next.model.to(t);
    return a + seconds(s * to_seconds(b - a));
  }
  int restarts() const { return estimator_.restarts(); }

 private:
  static constexpr Duration kEvery = std::chrono::seconds(3);
  static constexpr Duration kHalfWindow = std::chrono::seconds(6);  // of the estimator's twelve seconds
  static constexpr Duration kSetBack = std::chrono::seconds(1);     // more than samples overtake each other

  struct Kept {
    Instant<From> at;  // the newest stamp then
    ClockModel<From, To> model;
  };
  ClockEstimator<From, To> estimator_;
  std::vector<Kept> kept_;
  Instant<From> newest_;
};

}  // namespace palpate::inline time
