// Several loops that are executed again from their input traces, each in a thread of its own: a tick that took over a value
// of another thread waits until that thread has produced it.
//
// It cannot wait for ever: where all loops wait, or those that do not have ended, what is waited for never comes, and the
// playback has failed; reads then find nothing. Any thread.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace palpate::inline time {

class InputPlayback {
 public:
  explicit InputPlayback(int loops) : loops_(loops) {}

  // By each loop when it has ended, or cannot go on.
  void end_loop() {
    const std::lock_guard lock(mutex_);
    --loops_;
    if (waiting_ > 0 && waiting_ >= loops_) fail();
  }
  // What a loop has awaited never came.
  bool failed() const {
    const std::lock_guard lock(mutex_);
    return failed_;
  }

  // For what passes values between threads. produce() runs `change` and wakes who waits; await() returns when `there()`
  // holds, or false where it never will. Both run under one lock.
  template <typename Change>
  void produce(Change&& change) {
    const std::lock_guard lock(mutex_);
    change();
    ++productions_;
    waiting_ = 0;  // they look again
    produced_.notify_all();
  }
  template <typename There>
  bool await(There&& there) {
    std::unique_lock lock(mutex_);
    while (!failed_ && !there()) {
      const std::uint64_t seen = productions_;
      if (++waiting_ >= loops_) fail();
      produced_.wait(lock, [&] { return failed_ || productions_ != seen; });
    }
    return !failed_;
  }

 private:
  void fail() {
    failed_ = true;
    produced_.notify_all();
  }

  mutable std::mutex mutex_;
  std::condition_variable produced_;
  std::uint64_t productions_ = 0;
  int loops_, waiting_ = 0;  // waiting: since the last production
  bool failed_ = false;
};

}  // namespace palpate::inline time
