// How one clock reads when another reads t: the only way from Instant<From> to Instant<To>.
//
// ClockModel is a value: an affine map (reference instants and rate), with a stated uncertainty, and with the
// short remainder of a correction that was not allowed to jump. ClockEstimator makes one out of one-way
// stamps of a device, ClockSync out of exchanges between two hosts. The estimators belong to one thread each
// and do not allocate; hand the model to other threads through a Mailbox.
#pragma once

#include <algorithm>
#include <optional>

#include "palpate/time/clock_math.h"
#include "palpate/time/instant.h"

namespace palpate::inline time {

using ClockPhase = clock_math::Phase;

template <typename From, typename To>
class ClockModel {
 public:
  // Both clocks read the same (one machine, one clock).
  ClockModel() = default;
  // `to` reads to_reference when `from` reads from_reference, and gains drift_ppm on it.
  ClockModel(Instant<From> from_reference, Instant<To> to_reference, double drift_ppm,
             Duration uncertainty = Duration(0), double drift_uncertainty_ppm = 0.0)
      : map_{.from_ns = from_reference.ns(),
             .to_ns = to_reference.ns(),
             .drift = drift_ppm * 1e-6,
             .uncertainty_ns = static_cast<double>(uncertainty.count()),
             .drift_uncertainty = drift_uncertainty_ppm * 1e-6} {}
  explicit ClockModel(const clock_math::Map& map) : map_(map) {}

  Instant<To> to(Instant<From> t) const { return {Duration(map_.forward(t.ns()))}; }
  Instant<From> back(Instant<To> t) const { return {Duration(map_.backward(t.ns()))}; }
  double drift_ppm() const { return map_.drift * 1e6; }
  // Lead of the `to` clock at time t of the `from` clock.
  Duration offset(Instant<From> t) const { return Duration(map_.forward(t.ns()) - t.ns()); }
  // How far to(t) may be from the truth, as the estimator believes (about three standard deviations plus what
  // no estimator can see: see there). Grows away from the data.
  Duration uncertainty(Instant<From> t) const { return Duration(std::llround(map_.uncertainty_at(t.ns()))); }

 private:
  clock_math::Map map_;
};

// Offset and drift of a device's clock from stamps that arrive late: received = model(stamp) + latency +
// jitter.
//
// The line follows the lower edge of the cloud, because latency and jitter only ever delay. Usable after the
// first sample. What stays in it is the *smallest* latency: model().to(stamp) is the time at which the sample
// would have arrived at best, not the time at which it was taken; that constant is a calibrated delay of the
// device (see calibrate hand-eye, calibrate arm). A device clock that restarts is noticed and counted.
template <typename From, typename To>
class ClockEstimator {
 public:
  // False: the stamp is older than the window and was not used. `waited`: how long before `received` it may
  // have come, unseen; the time since one last looked. Where that beats with the device's rhythm the waiting
  // does not average out, so all of it is in the stated uncertainty.
  bool add(Instant<From> stamp, Instant<To> received, Duration waited = Duration(0)) {
    return core_.add(stamp.ns(), received.ns(), waited.count());
  }
  ClockModel<From, To> model() const { return ClockModel<From, To>(core_.map()); }
  ClockPhase phase() const { return core_.phase(); }
  int restarts() const { return core_.restarts(); }

 private:
  clock_math::Envelope core_;
};

// Offset and drift between two hosts from repeated exchanges, the remote one being the reference.
//
// Published uncertainty = half the round trip of the exchanges used (nobody can see how it splits over the
// two ways)
// + three standard deviations of the fit + what slewing still has to correct. The published time steps only
// while starting and after a restart; otherwise it slews by at most 500 ppm.
template <typename Local, typename Remote>
class ClockSync {
 public:
  enum class Result : std::uint8_t {
    used,
    impossible,   // stamps that no pair of clocks can give: not used
    contradicts,  // outside what delay can explain: not used, phase() is doubtful
    restarted,    // the third contradiction in agreement: the peer's clock was stepped or stood still; begun
                  // anew
  };

  static constexpr Duration kStandsStill = std::chrono::seconds(10);

  // t1 local send, t2 remote receive, t3 remote send, t4 local receive.
  Result add(Instant<Local> t1, Instant<Remote> t2, Instant<Remote> t3, Instant<Local> t4) {
    const auto result = core_.add(t1.ns(), t2.ns(), t3.ns(), t4.ns());
    if (result == clock_math::Exchange::Result::restarted && last_ &&
        last_->remote - model().to(last_->local) > kStandsStill)
      last_.reset();
    return static_cast<Result>(result);
  }
  ClockModel<Local, Remote> model() const { return ClockModel<Local, Remote>(core_.map()); }
  ClockPhase phase() const { return core_.phase(); }
  int restarts() const { return core_.restarts(); }
  int exchanges() const { return core_.count(); }
  Duration lowest_round_trip() const { return Duration(core_.lowest_round_trip_ns()); }
  // When to ask again: a burst at the start, after a restart and in doubt, else ten times a second.
  Duration interval() const { return Duration(phase() == ClockPhase::tracking ? 100'000'000 : 20'000'000); }

  // The remote time at t, never running backwards: for calls whose t does not decrease the result does not
  // decrease, whatever is added between them; it stands still where the model stepped back. Only a peer whose
  // clock was found set back by more than kStandsStill is followed there: nobody would wait that long.
  Instant<Remote> remote_time(Instant<Local> t) {
    Instant<Remote> result = model().to(t);
    if (last_) result = t >= last_->local ? std::max(result, last_->remote) : std::min(result, last_->remote);
    last_ = Pair{t, result};
    return result;
  }

 private:
  struct Pair {
    Instant<Local> local;
    Instant<Remote> remote;
  };
  clock_math::Exchange core_;
  std::optional<Pair> last_;
};

}  // namespace palpate::inline time
