#include "palpate/core/crash_words.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <exception>
#include <stdexcept>

#include "palpate/core/guest_call.h"
#include "tests/sanitized.h"

namespace palpate::inline core {
namespace {

void let_go(void* context) noexcept {
  const char* words = static_cast<const char*>(context);
  [[maybe_unused]] const auto written = write(STDERR_FILENO, words, 12);
}

void prepare() {
  static char words[] = "arm let go; ";
  say_crashes(let_go, words);
}

void make_a_mistake() { throw std::runtime_error("a guest's mistake"); }
void (*volatile mistake)() = make_a_mistake;  // which no compiler looks into
void throw_where_nothing_may_be_thrown() noexcept { mistake(); }

TEST(CrashWords, NameWhoseCodeItWasAndTakeForcesAwayFirst) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  EXPECT_EXIT(
      {
        prepare();
        const GuestCall named("the contact law of 'guest'");
        raise(SIGSEGV);
      },
      testing::KilledBySignal(SIGSEGV),
      "arm let go; palpate: crashed: the contact law of 'guest' touched memory that is not its own; forces "
      "are off");
  EXPECT_EXIT(
      {
        prepare();
        const GuestCall named("the arm's driver");
        throw_where_nothing_may_be_thrown();
      },
      testing::KilledBySignal(SIGABRT), "arm let go; palpate: crashed: the arm's driver gave up");
  EXPECT_EXIT(
      {
        prepare();
        raise(SIGFPE);
      },
      testing::KilledBySignal(SIGFPE), "palpate: crashed: the program itself divided by zero");
}

TEST(GuestCall, IsNestedAndEndsWithItsCall) {
  EXPECT_EQ(GuestCall::now(), nullptr);
  {
    const GuestCall outer("outer");
    {
      const GuestCall inner("inner");
      EXPECT_STREQ(GuestCall::now(), "inner");
    }
    EXPECT_STREQ(GuestCall::now(), "outer");
  }
  EXPECT_EQ(GuestCall::now(), nullptr);
}

#ifndef PALPATE_SANITIZED  // a sanitizer has a stack and words of its own for this
// Deeper and deeper, on purpose.
#if defined(__clang__)
__attribute__((optnone))
#else
__attribute__((optimize("O0")))
#endif
int fall(volatile char* above, long depth) {
  if (depth == 0) return 0;
  volatile char room[4096];
  room[0] = above[0];
  return fall(room, depth - 1) + room[0];
}

TEST(CrashWords, HaveAStackOfTheirOwnWhereAThreadHasOverrunItsStack) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  EXPECT_EXIT(
      {
        prepare();
        give_crash_stack();
        const GuestCall named("the application 'guest'");
        volatile char ground = 0;
        fall(&ground, 1'000'000'000);
      },
      testing::KilledBySignal(SIGSEGV), "palpate: crashed: the application 'guest' touched memory");
}
#endif

}  // namespace
}  // namespace palpate::inline core
