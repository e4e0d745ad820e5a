#include "palpate/device/heartbeat_monitor.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

constexpr std::int64_t kAllowed = 1000;

// Looks every 20 from `from` up to `to`; when the peer was first found gone, or -1.
std::int64_t gone_at(HeartbeatMonitor& watch, std::int64_t from, std::int64_t to, std::int64_t beat) {
  for (std::int64_t now = from; now <= to; now += 20)
    if (watch.gone(now, beat)) return now;
  return -1;
}

TEST(HeartbeatMonitor, APeerIsGoneAfterTheAllowedSilence) {
  HeartbeatMonitor watch(kAllowed);
  EXPECT_EQ(gone_at(watch, 5000, 9000, 4900), 5900);
  EXPECT_FALSE(watch.gone(9020, 9010));  // another has come
}

TEST(HeartbeatMonitor, WhoWasSilentLongBeforeTheFirstLookIsGoneAtOnce) {
  HeartbeatMonitor watch(kAllowed);
  EXPECT_TRUE(watch.gone(5000, 100));
}

TEST(HeartbeatMonitor, APauseOfBothIsNoSilence) {
  HeartbeatMonitor watch(kAllowed);
  EXPECT_EQ(gone_at(watch, 5000, 5100, 5000), -1);
  EXPECT_EQ(gone_at(watch, 95'000, 95'960, 5080), -1);  // it may wake up a little later than we
  EXPECT_FALSE(watch.gone(95'980, 95'970));
}

TEST(HeartbeatMonitor, WhoDiedDuringAPauseIsFoundGoneAfterIt) {
  HeartbeatMonitor watch(kAllowed);
  EXPECT_EQ(gone_at(watch, 5000, 5100, 5000), -1);
  EXPECT_EQ(gone_at(watch, 95'000, 99'000, 5080), 96'000);
  EXPECT_TRUE(watch.gone(199'000, 5080));  // another pause does not bring it back
}

TEST(HeartbeatMonitor, WhoLooksRarelyFindsADeadPeerAtTheFourthLook) {
  HeartbeatMonitor watch(kAllowed);
  EXPECT_FALSE(watch.gone(10'000, 9999));
  for (const std::int64_t now : {20'000, 30'000, 40'000}) EXPECT_FALSE(watch.gone(now, 10'500)) << now;
  EXPECT_TRUE(watch.gone(50'000, 10'500));
}

TEST(HeartbeatMonitor, APauseIsNoSilenceForWhoLooksRarelyEither) {
  HeartbeatMonitor watch(kAllowed);
  EXPECT_FALSE(watch.gone(10'000, 9900));
  EXPECT_FALSE(watch.gone(10'600, 10'550));  // a slow picture; the peer is stopped now, then we
  EXPECT_FALSE(watch.gone(12'100, 10'550));
  EXPECT_FALSE(watch.gone(12'700, 10'550));  // the peer has not been woken yet
  EXPECT_FALSE(watch.gone(13'300, 13'290));
}

}  // namespace
}  // namespace palpate::device
