// Which code of others this thread is running now: for whoever has to name it when the process crashes.
#pragma once

namespace palpate::inline core {

// For as long as it lives the thread runs `who`, which must outlive it: "the contact law of 'touch'". May be
// nested; costs a store. No lock, no allocation; now() may be called by a signal handler.
class GuestCall {
 public:
  explicit GuestCall(const char* who) noexcept : before_(running_) { running_ = who; }
  ~GuestCall() { running_ = before_; }
  GuestCall(const GuestCall&) = delete;
  GuestCall& operator=(const GuestCall&) = delete;
  static const char* now() noexcept { return running_; }  // of the calling thread; null: none

 private:
  static inline thread_local const char* running_ = nullptr;
  const char* before_;
};

}  // namespace palpate::inline core
