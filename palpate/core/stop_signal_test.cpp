#include "palpate/core/stop_signal.h"

#include <gtest/gtest.h>

namespace palpate::inline core {
namespace {

TEST(StopSignal, ASignalSetsTheFlag) {
  const std::atomic<bool>& stop = stop_requested();
  EXPECT_FALSE(stop.load());
  std::raise(SIGTERM);
  EXPECT_TRUE(stop.load());
}

TEST(StopSignal, AHandlerThatCannotBeInstalledIsNoSecret) {
  EXPECT_THROW(handle_signal(SIGKILL, [](int) {}), std::system_error);
}

}  // namespace
}  // namespace palpate::inline core
