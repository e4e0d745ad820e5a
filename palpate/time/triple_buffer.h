// The newest value, from one writing thread to one reading thread, neither of which ever waits.
//
// A triple buffer: the writer fills a slot of its own and exchanges it with the middle one, the reader
// exchanges its slot with the middle one when that is fresh. T is copied; nothing is torn, nothing allocates.
// Values in between are dropped. For more readers, or over shared memory, there is Mailbox (palpate/core/broadcast_ring.h),
// whose values are plain bytes; matrices and poses of Eigen are not.
//
// Where an InputTrace is in hand it learns which value read() took over; where one is played back, read() gives that value.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>

#include "palpate/time/input_playback.h"
#include "palpate/time/input_trace.h"

namespace palpate::inline time {

template <typename T>
class TripleBuffer {
 public:
  // The writing thread only.
  void write(const T& value) {
    ++written_;
    if (InputPlayback* playback = played_back()) return keep(value, *playback);
    slots_[back_] = value;
    numbers_[back_] = written_;
    back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }
  // The reading thread only. True, and `value` the newest, if something was written since the last call.
  bool read(T& value) {
    if (InputPlayback* playback = played_back()) return read_kept(value, *playback);
    const bool fresh = (middle_.load(std::memory_order_relaxed) & kFresh) != 0;
    if (fresh) {
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
      value = slots_[front_];
    }
    InputTrace::pass(fresh ? numbers_[front_] : 0);
    return fresh;
  }

 private:
  using Kept = std::deque<std::pair<std::uint64_t, T>>;

  static InputPlayback* played_back() {
    const InputTrace* trace = InputTrace::current();
    return trace == nullptr ? nullptr : trace->playback();
  }
  // Playback: every value until a later one has been read.
  void keep(const T& value, InputPlayback& playback) {
    playback.produce([&] {
      if (!kept_) kept_ = std::make_unique<Kept>();
      kept_->emplace_back(written_, value);
    });
  }
  bool read_kept(T& value, InputPlayback& playback) {
    const std::uint64_t number = InputTrace::pass(0);
    if (number == 0) return false;
    return playback.await([&] {
      if (!kept_) return false;
      while (!kept_->empty() && kept_->front().first < number) kept_->pop_front();
      if (kept_->empty() || kept_->front().first != number) return false;
      value = kept_->front().second;
      return true;
    });
  }

  static constexpr unsigned kIndex = 3, kFresh = 4;
  std::array<T, 3> slots_{};
  std::array<std::uint64_t, 3> numbers_{};  // of the values in the slots, counted from 1
  std::unique_ptr<Kept> kept_;              // under the playback's lock
  alignas(64) std::atomic<unsigned> middle_{1};
  alignas(64) unsigned back_ = 0;
  std::uint64_t written_ = 0;  // the writer's
  alignas(64) unsigned front_ = 2;
};

}  // namespace palpate::inline time
