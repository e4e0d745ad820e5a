// What a thread has used so far: whether code that took long has computed or waited, or whether the machine
// has merely taken its core away.
#pragma once

#include <sys/resource.h>

#include <cstdint>

#include "palpate/time/clock.h"

namespace palpate::inline time {

struct ThreadTime {
  Duration wall{0}, cpu{0};
  std::uint64_t waits = 0;  // times it gave its core up by itself: slept, waited for a lock or a file
};

// now() is of the calling thread; it neither locks, allocates nor throws. Simulated ones are for tests.
class ThreadClock {
 public:
  virtual ~ThreadClock() = default;
  virtual ThreadTime now() const noexcept = 0;
};

// About half a microsecond.
class MachineThreadClock : public ThreadClock {
 public:
  ThreadTime now() const noexcept override {
    timespec cpu{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
    rusage used{};
    getrusage(RUSAGE_THREAD, &used);
    return {Duration(MonotonicClock<PhysicsClock>::monotonic_ns()),
            Duration(static_cast<std::int64_t>(cpu.tv_sec) * 1'000'000'000 + cpu.tv_nsec),
            static_cast<std::uint64_t>(used.ru_nvcsw)};
  }
};

}  // namespace palpate::inline time
