// Real-time rights of the calling thread: first-in-first-out scheduling and
// memory that is not swapped out.
#pragma once

#include <string>

#include "palpate/core/file_descriptor.h"

namespace palpate::inline time {

struct RealTimeGrant {
  int fifo_priority = 0;  // 0: the ordinary scheduler
  int fifo_errno = 0;     // why not
  bool memory_locked = false;
  int memory_errno = 0;

  bool fifo() const { return fifo_priority > 0; }
  // One line for the log: what was granted, and what to do about the rest.
  std::string describe() const;
};

// Asks for SCHED_FIFO at this priority and for locked memory (of the whole
// process, from now on; pages are locked as they are touched), and touches all code and the
// stack that a loop may need. Without FIFO sleeps still end on time: timer
// slack is set to 1 ns instead of the usual 50 us. Children do not inherit the
// priority.
RealTimeGrant enter_real_time(int priority);

// Keeps the machine's idle cores from sleeping deeply while it lives (/dev/cpu_dma_latency at 0): a thread is
// then woken within some 20 us instead of 40. Costs power; without the right to do so nothing happens.
class CoresAwake {
 public:
  CoresAwake();
  bool granted() const { return static_cast<bool>(file_); }

 private:
  FileDescriptor file_;  // the kernel keeps to it as long as this is open
};

// Of the calling thread: sleeps that end as near the wanted time as the
// scheduler allows.
void sharpen_sleep();

// Of the calling thread and of those it starts from now on: turns of 0.1 ms, so that the ordinary scheduler
// lets it in at once when it is woken instead of at the end of another thread's turn. Needs no rights and
// takes no share from others. Linux 6.12 or later; others ignore it.
void ask_for_short_turns();

// Of the process, once, before its threads start: memory that is freed stays with it, up to 64 MiB in each
// of malloc's arenas, instead of going back to the system. Large messages then cost no page faults.
void keep_freed_memory();

// Names the calling thread (first 15 characters count) and binds it to one core
// (< 0: any).
void name_and_pin_thread(const char* name, int cpu);

}  // namespace palpate::inline time
