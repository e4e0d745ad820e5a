// The newest value, from one writing thread to one reading thread, neither of which ever waits.
//
// A triple buffer: the writer fills a slot of its own and exchanges it with the middle one, the reader
// exchanges its slot with the middle one when that is fresh. T is copied; nothing is torn, nothing allocates.
// Values in between are dropped. For more readers, or over shared memory, there is Mailbox (palpate/core/broadcast_ring.h),
// whose values are plain bytes; matrices and poses of Eigen are not.
#pragma once

#include <array>
#include <atomic>

namespace palpate::inline time {

template <typename T>
class TripleBuffer {
 public:
  // The writing thread only.
  void write(const T& value) {
    slots_[back_] = value;
    back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }
  // The reading thread only. True, and `value` the newest, if something was written since the last call.
  bool read(T& value) {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    value = slots_[front_];
    return true;
  }

 private:
  static constexpr unsigned kIndex = 3, kFresh = 4;
  std::array<T, 3> slots_{};
  alignas(64) std::atomic<unsigned> middle_{1};
  alignas(64) unsigned back_ = 0;
  alignas(64) unsigned front_ = 2;
};

}  // namespace palpate::inline time
