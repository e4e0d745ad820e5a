// A device's clock as its samples show it, and the moments at which it was found set.
//
// A clock that was set forward shows at once: no sample arrives before it was taken. One that was set back
// only makes samples look late, as a busy machine does, too; but that has them late now more and now less,
// while a clock that was set has all of them late by the same. While that is being decided a sample's time is
// not known. What is set by less than kDoubt is learned anew without a word: it may as well be that the way
// of the samples has become shorter, as when a machine has started and has less to do. Host time of the
// graphics server. One thread.
#pragma once

#include <cstdlib>
#include <optional>

#include "palpate/time/clock_model.h"
#include "palpate/time/instant.h"

namespace palpate::server::graphics {

template <typename DeviceClock>
class WatchedClock {
 public:
  // Samples later than this are doubted; so many of them in a row, over so long a time, all as late to within
  // kSteady, are no late samples.
  static constexpr Duration kDoubt = std::chrono::milliseconds(200), kSteady = std::chrono::milliseconds(10),
                            kDoubtLasts = std::chrono::milliseconds(50);
  static constexpr int kDoubtful = 3;

  // The sample's moment; none while it is doubted. `waited` as in ClockEstimator::add().
  std::optional<Instant<GraphicsClock>> take(Instant<DeviceClock> stamp, Instant<GraphicsClock> now,
                                             Duration waited) {
    set_ = false;
    const Duration late = now - clock_.model().to(stamp);
    if (clock_.phase() == ClockPhase::tracking && late > kDoubt + waited)
      doubt(late, now);
    else
      doubtful_ = 0;
    if (doubtful_ >= kDoubtful && now - doubted_since_ >= kDoubtLasts) {
      clock_ = {};
      restarts_ = doubtful_ = 0;
      set_ = true;
    }
    clock_.add(stamp, now, waited);
    if (clock_.restarts() != restarts_) {
      restarts_ = clock_.restarts();
      set_ = set_ || std::abs(late.count()) > kDoubt.count();
    }
    if (doubtful_ > 0) return std::nullopt;
    return clock_.model().to(stamp);
  }
  // Whether the last sample showed that the clock was set, or had stood still: it is learned anew.
  bool found_set() const { return set_; }

 private:
  void doubt(Duration late, Instant<GraphicsClock> now) {
    if (doubtful_ == 0 || std::abs((late - doubted_late_).count()) > kSteady.count()) {
      doubtful_ = 0;
      doubted_late_ = late;
      doubted_since_ = now;
    }
    ++doubtful_;
  }

  ClockEstimator<DeviceClock, GraphicsClock> clock_;
  int restarts_ = 0, doubtful_ = 0;
  Duration doubted_late_{0};  // of the first doubtful sample
  Instant<GraphicsClock> doubted_since_;
  bool set_ = false;
};

}  // namespace palpate::server::graphics
