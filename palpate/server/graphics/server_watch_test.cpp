#include "palpate/server/graphics/server_watch.h"

#include <gtest/gtest.h>

#include "palpate/transport/exchange_rig_test.h"

namespace palpate::server::graphics {
namespace {

class WatchedServer : public ::testing::Test {
 protected:
  // Looks each millisecond until the physics server is seen as there, or gone.
  void run_until(bool there) {
    for (int ms = 0; ms < 10'000 && (watch_.there() != there || link_->peer_alive() != there); ++ms) {
      exchange_.wait_a_little();
      link_->poll();
      watch_.look(sync_, {exchange_.network.now().since_epoch});
    }
    ASSERT_EQ(watch_.there(), there);
  }

  const LogCapture told_;
  transport::testing::InProcessRig exchange_;
  std::unique_ptr<transport::StateService> service_ = std::move(*exchange_.serve());
  std::unique_ptr<transport::StateLink> link_ = exchange_.connect();
  ClockSync<GraphicsClock, PhysicsClock> sync_;
  ServerWatch watch_{*link_, "ipc:///run/physics"};
};

TEST_F(WatchedServer, ThatGoesAndComesBackIsToldOnceEach) {
  exchange_.until({link_.get()}, [&] { return link_->peer_alive(); });
  run_until(true);
  EXPECT_EQ(told_.text(), "");
  service_.reset();
  run_until(false);
  service_ = std::move(*exchange_.serve());
  run_until(true);
  EXPECT_EQ(told_.text(),
            "graphics: the physics server at ipc:///run/physics no longer answers; start `palpate physics` "
            "again; drawing goes on with the last state\n"
            "graphics: the physics server at ipc:///run/physics answers again\n");
  ASSERT_EQ(watch_.changes().size(), 2u);
  EXPECT_FALSE(watch_.changes()[0].there);
  EXPECT_TRUE(watch_.changes()[1].there);
  EXPECT_LT(watch_.changes()[0].time, watch_.changes()[1].time);
}

// A server that is set anew, or that refuses in other words, many times a second fills no log.
TEST_F(WatchedServer, ThatIsSetAgainAndAgainIsToldOfNowAndThen) {
  std::int64_t ahead = 0;
  Instant<GraphicsClock> now{std::chrono::seconds(1)};
  for (int ms = 0; ms < 25'000; ++ms, now += std::chrono::milliseconds(1)) {
    if (ms % 50 == 0) ahead += 1'000'000'000'000;
    sync_.add(now, {now.since_epoch + Duration(ahead)}, {now.since_epoch + Duration(ahead)}, now);
    watch_.look(sync_, now);
  }
  ASSERT_GT(sync_.restarts(), 300);
  const auto lines = told_.lines();
  ASSERT_EQ(lines.size(), 4u) << told_.text();  // the first: nobody answers here
  EXPECT_EQ(lines[1].text,
            "graphics: the physics server's clock was set, or stood still for a while; the clocks are "
            "synchronised anew");
  EXPECT_NE(lines[2].text.find("(and 199 times since it was last said)"), std::string::npos) << lines[2].text;
}

}  // namespace
}  // namespace palpate::server::graphics
