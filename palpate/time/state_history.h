// The states of the last seconds, and the state at any time among them, with the answer saying how it knew.
//
// State is trivially copyable and has a member `time`, an Instant<Clock>. One thread pushes, any number of
// threads ask; nobody locks, allocates or waits for another (memory model: palpate/core/broadcast_ring.h). A
// reader that was put to sleep until its entry was overwritten looks again. How to go between entries is the
// caller's business: interpolate(a, b, s) with s in (0, 1) and extrapolate(a, ahead).
//
// Search: first guess as if the entries were evenly spaced, which hits at once for a fixed rate; from there
// outwards in doubling steps and then by halves, so that uneven spacing costs O(log N). Times lie in an array
// of their own, to stay in the cache. Derivation and limits: docs/theory/state-history.md.
#pragma once

#include <memory>

#include "palpate/core/broadcast_ring.h"
#include "palpate/time/answer.h"
#include "palpate/time/instant.h"

namespace palpate::inline time {

// N entries are allocated (and touched) at construction; N - 1 can be relied on, the last is being written.
template <typename State, std::size_t N>
class StateHistory {
 public:
  using Time = decltype(State::time);
  using Answer = HistoryAnswer<State>;

  // Beyond the newest entry answers are extrapolated by at most this; 0 forbids it.
  explicit StateHistory(Duration max_extrapolation) : max_extrapolation_(max_extrapolation) {}

  // The one writer. Times must increase: false, and nothing stored, where one does not.
  bool push(const State& state) noexcept {
    const std::uint64_t k = data_->ring.count();
    const std::int64_t t = state.time.ns();
    if (k > 0 && t <= time(k - 1)) return false;
    data_->times[k % N].store(t, std::memory_order_relaxed);
    data_->ring.push(state);
    return true;
  }

  // Entries ever stored.
  std::uint64_t count() const noexcept { return data_->ring.count(); }

  template <typename Interpolate, typename Extrapolate>
  Answer at(Time when, Interpolate&& interpolate, Extrapolate&& extrapolate) const {
    const std::int64_t t = when.ns();
    Room<State> room_a, room_b;
    State &a = room_a.value(), &b = room_b.value();
    while (true) {
      const std::uint64_t n = data_->ring.count();
      if (n == 0) return {AnswerKind::too_new, Duration(0), State{}};
      const std::uint64_t newest = n - 1, oldest = n < N ? 0 : n - (N - 1);
      // Times are read first and may be overwritten meanwhile; what counts is the time inside the entry that
      // is copied afterwards. Where the two disagree the writer has lapped us and we look again.
      if (t >= time(newest)) {
        if (!data_->ring.read(newest, a) || a.time > when) continue;
        return beyond(when, a, extrapolate);
      }
      if (t < time(oldest)) {
        if (!data_->ring.read(oldest, a) || a.time <= when) continue;
        return {AnswerKind::too_old, when - a.time, a};
      }
      const std::uint64_t k = search(t, oldest, newest);
      if (!data_->ring.read(k, a) || a.time > when) continue;
      if (a.time == when) return {AnswerKind::exact, Duration(0), a};
      if (!data_->ring.read(k + 1, b) || b.time <= when) continue;
      return {AnswerKind::interpolated, Duration(0),
              interpolate(a, b, to_seconds(when - a.time) / to_seconds(b.time - a.time))};
    }
  }

 private:
  struct Data {
    BroadcastRing<State, N> ring;
    std::array<std::atomic<std::int64_t>, N> times{};
  };

  std::int64_t time(std::uint64_t k) const noexcept {
    return data_->times[k % N].load(std::memory_order_relaxed);
  }

  template <typename Extrapolate>
  Answer beyond(Time when, const State& newest, Extrapolate&& extrapolate) const {
    const Duration ahead = when - newest.time;
    if (ahead == Duration(0)) return {AnswerKind::exact, ahead, newest};
    if (ahead > max_extrapolation_) return {AnswerKind::too_new, ahead, newest};
    return {AnswerKind::extrapolated, ahead, extrapolate(newest, ahead)};
  }

  // The last entry not after t, given time(lo) <= t < time(hi).
  std::uint64_t search(std::int64_t t, std::uint64_t lo, std::uint64_t hi) const noexcept {
    const std::int64_t t_lo = time(lo), span = time(hi) - t_lo;
    const double share = span > 0 ? static_cast<double>(t - t_lo) / static_cast<double>(span) : 0.0;
    const double steps = static_cast<double>(hi - lo);
    const double guess_steps = share > 0.0 ? share * steps : 0.0;
    const std::uint64_t guess = guess_steps < steps ? lo + static_cast<std::uint64_t>(guess_steps) : hi - 1;
    std::uint64_t step = 1;
    if (time(guess) <= t) {
      lo = guess;
      while (lo + step < hi && time(lo + step) <= t) {
        lo += step;
        step *= 2;
      }
      if (lo + step < hi) hi = lo + step;
    } else {
      hi = guess;
      while (hi - lo > step && time(hi - step) > t) {
        hi -= step;
        step *= 2;
      }
      if (hi - lo > step) lo = hi - step;
    }
    while (hi - lo > 1) {
      const std::uint64_t middle = lo + (hi - lo) / 2;
      (time(middle) <= t ? lo : hi) = middle;
    }
    return lo;
  }

  std::unique_ptr<Data> data_ = std::make_unique<Data>();
  Duration max_extrapolation_;
};

}  // namespace palpate::inline time
