#include "palpate/time/real_time.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <thread>

namespace palpate::inline time {
namespace {

// The first fields of sched_attr as the system call gives them.
struct SchedulingSeen {
  std::uint32_t size = 0, policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime = 0, deadline = 0, period = 0;
};
SchedulingSeen scheduling() {
  SchedulingSeen seen;
  EXPECT_EQ(syscall(SYS_sched_getattr, 0, &seen, sizeof seen, 0), 0);
  return seen;
}

// In a thread of its own: what is asked for stays with the thread.
void in_a_thread(void (*check)()) { std::thread(check).join(); }

TEST(RealTime, ShortTurnsChangeNeitherClassNorNicenessAndPassOnToThreads) {
  in_a_thread([] {
    const sched_param ordinary{};
    ASSERT_EQ(sched_setscheduler(0, SCHED_OTHER, &ordinary), 0);
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 3);
    const auto before = scheduling();
    ask_for_short_turns();
    const auto after = scheduling();
    EXPECT_EQ(after.policy, before.policy);
    EXPECT_EQ(after.nice, before.nice);
    // Before Linux 6.12 an ordinary thread has no turns of its own, and nothing changes.
    EXPECT_EQ(after.runtime, before.runtime == 0 ? 0u : 100'000u);
    static std::uint64_t passed_on;
    passed_on = after.runtime;
    in_a_thread([] { EXPECT_EQ(scheduling().runtime, passed_on); });
  });
}

// SCHED_BATCH is anybody's, SCHED_FIFO takes a right.
TEST(RealTime, AThreadOfAnotherClassStaysInIt) {
  in_a_thread([] {
    for (const int policy : {SCHED_BATCH, SCHED_FIFO}) {
      sched_param parameters{};
      parameters.sched_priority = policy == SCHED_FIFO ? 5 : 0;
      const int refused = pthread_setschedparam(pthread_self(), policy, &parameters);
      if (policy == SCHED_FIFO && refused == EPERM) continue;
      ASSERT_EQ(refused, 0);
      const auto before = scheduling();
      ask_for_short_turns();
      EXPECT_EQ(sched_getscheduler(0), policy);
      EXPECT_EQ(scheduling().priority, before.priority);
      EXPECT_EQ(scheduling().runtime, before.runtime);
    }
  });
}

}  // namespace
}  // namespace palpate::inline time
