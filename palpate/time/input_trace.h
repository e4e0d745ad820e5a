// What one tick of a loop learns from outside its own thread, as numbers: which value of another thread it took over, a wish
// that had come, how long a guest took. Written down while a session is recorded; played back when it is executed again, so
// that each tick learns the same as it did then.
//
// A tick runs with a trace in hand by InputTrace::Scope; without one pass() hands on what it is given and nothing else
// happens. Writing takes no lock and no memory. Playing may wait: a value of another thread is there when that thread has
// produced it (InputPlayback).
//
// After: deterministic replay by a log of what is not deterministic (Ronsse, De Bosschere, "RecPlay", ACM TOCS 17(2), 1999).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::inline time {

class InputPlayback;

class InputTrace {
 public:
  static constexpr std::size_t kMost = 16;  // of a tick

  // Begins anew, for the next tick.
  void write() noexcept {
    playback_ = nullptr;
    count_ = position_ = 0;
    exact_ = true;
  }
  // The tick learns `values`, in this order.
  void play(std::span<const std::uint64_t> values, InputPlayback& playback) noexcept;

  // By the code that learns something: what it goes on with is what this returns.
  static std::uint64_t pass(std::uint64_t found) noexcept {
    return current_ == nullptr ? found : current_->exchange(found);
  }
  static InputTrace* current() noexcept { return current_; }

  InputPlayback* playback() const { return playback_; }  // null: it is written
  std::span<const std::uint64_t> values() const { return {values_.data(), count_}; }
  // Written: there was room for all. Played: the tick learned as many things as were written.
  bool exact() const { return exact_ && (playback_ == nullptr || position_ == count_); }

  // This thread's trace for as long as it lives.
  class Scope {
   public:
    explicit Scope(InputTrace* trace) noexcept : before_(current_) { current_ = trace; }
    ~Scope() { current_ = before_; }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    InputTrace* before_;
  };

 private:
  std::uint64_t exchange(std::uint64_t found) noexcept {
    if (playback_ == nullptr) {
      if (count_ < kMost)
        values_[count_++] = found;
      else
        exact_ = false;
      return found;
    }
    if (position_ < count_) return values_[position_++];
    exact_ = false;
    return 0;
  }

  static inline thread_local InputTrace* current_ = nullptr;
  std::array<std::uint64_t, kMost> values_{};
  std::size_t count_ = 0, position_ = 0;
  InputPlayback* playback_ = nullptr;
  bool exact_ = true;
};

}  // namespace palpate::inline time
