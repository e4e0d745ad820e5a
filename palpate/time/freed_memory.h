// Memory that a burst has left behind, back to the system.
#pragma once

namespace palpate::inline time {

// Of the process: what malloc has free, also where keep_freed_memory() keeps it. Locked memory (enter_real_time())
// cannot be given back and is unlocked for that moment. Takes milliseconds, in which other threads that ask for
// memory may wait: not for a loop, and not in turn with one.
void give_back_freed_memory();

}  // namespace palpate::inline time
