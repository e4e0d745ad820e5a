// Memory that a burst has left behind, back to the system.
#pragma once

#include <cstddef>

namespace palpate::inline time {

// Of the process: what malloc has free, but for the newest 64 MiB of each thread's, also where
// keep_freed_memory() keeps it. Locked memory (enter_real_time()) cannot be given back and is unlocked for that
// moment. Takes milliseconds, in which other threads that ask for memory may wait: not for a loop, and not in
// turn with one.
void give_back_freed_memory();

// What the process has in memory now; 0 where that cannot be told.
std::size_t resident_bytes();

}  // namespace palpate::inline time
