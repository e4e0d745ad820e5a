// Memory that a burst has left behind, back to the system.
#pragma once

#include <cstddef>

namespace palpate::inline time {

// Of the process: what malloc has free, but for the newest 64 MiB of each thread's, also where
// keep_freed_memory() keeps it. Locked memory (enter_real_time()) cannot be given back and is unlocked for that
// moment. Takes milliseconds, in which other threads that ask for memory may wait: not for a loop, and not in
// turn with one.
void give_back_freed_memory();

// Tells when there is memory to give back. malloc counts as free what it has given back, too, so it takes growth: of
// the process, or of what is free. The second, because memory may be given back while a burst is still being freed;
// its rest is then free without the process ever growing again. One thread.
class FreedMemory {
 public:
  // Bytes: what may lie free, what the process has, what malloc has free.
  FreedMemory(std::size_t kept, std::size_t resident, std::size_t freed);

  bool has_grown(std::size_t resident, std::size_t freed);
  void was_given_back(std::size_t resident, std::size_t freed);

 private:
  std::size_t kept_, least_resident_, least_freed_;  // since memory was given back
};

// What malloc counts as free in the process, bytes.
std::size_t freed_bytes();

// What the process has in memory now; 0 where that cannot be told.
std::size_t resident_bytes();

}  // namespace palpate::inline time
