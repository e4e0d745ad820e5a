// A queue of fixed length between exactly one writing and one reading thread: no lock, no allocation of its
// own.
//
// Lamport's ring (1977): each side owns one index. push() says no when the queue is full, pop() when it is
// empty. Several writers are fine if something else lets only one in at a time.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <utility>

namespace palpate::transport {

template <typename T, std::size_t N>
class HandoverQueue {
 public:
  bool push(T value) {
    const std::size_t in = in_.load(std::memory_order_relaxed);
    if (in - out_.load(std::memory_order_acquire) == N) return false;
    slots_[in % N] = std::move(value);
    in_.store(in + 1, std::memory_order_release);
    return true;
  }
  bool pop(T& value) {
    const std::size_t out = out_.load(std::memory_order_relaxed);
    if (out == in_.load(std::memory_order_acquire)) return false;
    value = std::move(slots_[out % N]);
    out_.store(out + 1, std::memory_order_release);
    return true;
  }
  bool full() const {
    return in_.load(std::memory_order_acquire) - out_.load(std::memory_order_acquire) == N;
  }

 private:
  std::array<T, N> slots_{};
  alignas(64) std::atomic<std::size_t> in_{0};
  alignas(64) std::atomic<std::size_t> out_{0};
};

}  // namespace palpate::transport
