// Watches calls into code of others that the haptic tick depends on: what each took, and whether one is too
// slow again and again.
//
// A call is too slow that computes for longer than its bound, or takes longer because it waits. One that took
// long because the thread was without a core is not its fault. Each slow call counts one; a hundred others
// take that one away again. Haptic thread; cost() from any. No lock, no allocation.
#pragma once

#include <algorithm>
#include <utility>

#include "palpate/time/input_trace.h"
#include "palpate/time/jitter_histogram.h"
#include "palpate/time/thread_clock.h"

namespace palpate::haptics {

class GuestWatch {
 public:
  static constexpr double kMostSlow = 10.0, kForgiven = 0.01;

  // Without a clock, in lock-step, no call takes any time.
  GuestWatch(Duration bound, const ThreadClock* clock) : bound_(bound), clock_(clock) {}

  template <typename Call>
  decltype(auto) time(Call&& call) {
    slow_ = std::max(0.0, slow_ - kForgiven);
    if (clock_ == nullptr) return std::forward<Call>(call)();
    const Timed timed{*this, clock_->now()};
    return std::forward<Call>(call)();
  }
  Duration took() const { return took_; }  // the last call, by the wall's clock
  bool failed() const { return slow_ >= kMostSlow; }
  std::uint64_t overruns() const { return overruns_; }  // calls that were too slow
  const JitterHistogram& cost() const { return cost_; }
  // What a call may never do (throw, ask for a bad force) counts as one that was too slow.
  void blame() { slow_ += 1.0; }
  void forgive() { slow_ = 0.0; }

 private:
  struct Timed {
    GuestWatch& watch;
    ThreadTime begun;
    ~Timed() { watch.judge(begun); }
  };
  void judge(const ThreadTime& begun) {
    const ThreadTime ended = clock_->now();
    const Duration took = std::max(Duration(0), ended.wall - begun.wall);
    const bool waited = ended.waits != begun.waits;
    const bool judged = ended.cpu - begun.cpu > bound_ || (took > bound_ && waited);
    const std::uint64_t known = InputTrace::pass(2 * static_cast<std::uint64_t>(took.count()) + judged);
    took_ = Duration(static_cast<std::int64_t>(known / 2));
    cost_.add(took_);
    const bool slow = known % 2 != 0;
    overruns_ += slow;
    slow_ += slow ? 1.0 : 0.0;
  }

  Duration bound_, took_{0};
  const ThreadClock* clock_;
  double slow_ = 0.0;
  std::uint64_t overruns_ = 0;
  JitterHistogram cost_;
};

}  // namespace palpate::haptics
