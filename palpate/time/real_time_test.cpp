#include "palpate/time/real_time.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

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
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 3);
    const auto before = scheduling();
    if (before.policy != SCHED_OTHER) GTEST_SKIP() << "not under the ordinary scheduler here";
    ask_for_short_turns();
    const auto after = scheduling();
    EXPECT_EQ(after.policy, before.policy);
    EXPECT_EQ(after.nice, before.nice);
    if (before.runtime == 0)
      GTEST_SKIP() << "this kernel knows no turns of an ordinary thread (before Linux 6.12)";
    EXPECT_EQ(after.runtime, 100'000u);
    in_a_thread([] { EXPECT_EQ(scheduling().runtime, 100'000u); });
  });
}

TEST(RealTime, ARealTimeThreadStaysOne) {
  in_a_thread([] {
    sched_param parameters{};
    parameters.sched_priority = 5;
    if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) != 0)
      GTEST_SKIP() << "no right to SCHED_FIFO here (palpate doctor)";
    ask_for_short_turns();
    EXPECT_EQ(sched_getscheduler(0), SCHED_FIFO);
    EXPECT_EQ(scheduling().priority, 5u);
  });
}

}  // namespace
}  // namespace palpate::inline time
