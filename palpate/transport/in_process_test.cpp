// The in-process transport's own promises: virtual time, faults as asked for, the same run for the same seed.
#include "palpate/transport/in_process.h"

#include <gtest/gtest.h>

#include "palpate/transport/exchange_rig_test.h"

namespace palpate::transport {
namespace {

using testing::InProcessRig;

// One request per 33 ms frame, drawn 20 ms after it; everything the link saw goes into a text.
struct Play {
  ExchangeCounters counters;
  std::string trace;
};
Play play(const ChannelModel& model, std::uint64_t seed, int frames) {
  InProcessRig rig(model, seed);
  auto server = rig.serve();
  auto link = rig.connect();
  Play run;
  const Instant<TrueTime> start = rig.network.now();
  for (int i = 1; i <= frames; ++i) {
    const Instant<TrueTime> frame = start + std::chrono::milliseconds(33 * i);
    rig.network.advance_to(frame);
    link->request(static_cast<std::uint64_t>(i), {frame.since_epoch});
    for (int ms = 1; ms <= 20; ++ms) {
      rig.network.advance_to(frame + std::chrono::milliseconds(ms));
      link->poll();
      for (const ArrivedState& a : link->arrived()) {
        run.trace += fmt::format("{} {} {} {}\n", a.reply.number, a.sent.ns(), a.received.ns(), a.newest);
      }
    }
    link->frame_drawn(static_cast<std::uint64_t>(i));
  }
  for (int ms = 0; ms < 2000; ++ms) {
    rig.wait_a_little();
    link->poll();
  }
  run.counters = link->counters();
  return run;
}

TEST(InProcessNetwork, TheSameSeedGivesTheSameRunToTheBit) {
  const ChannelModel model{.loss = 0.05, .duplication = 0.05, .reordering = 0.05};
  const Play a = play(model, 5, 300), b = play(model, 5, 300), c = play(model, 6, 300);
  EXPECT_EQ(a.trace, b.trace);
  EXPECT_EQ(a.counters, b.counters);
  EXPECT_NE(a.trace, c.trace);
}

TEST(InProcessNetwork, WithoutFaultsEveryFrameHasItsOwnState) {
  const Play run = play({}, 1, 300);
  EXPECT_EQ(run.counters.frames_in_time, 300u);
  EXPECT_EQ(run.counters.late + run.counters.lost + run.counters.duplicated + run.counters.out_of_order, 0u);
}

// Between two signs of life, 200 ms apart, at five moments: whoever asks hears of it within the time
// that three messages take.
TEST(InProcessNetwork, ADevicesTroubleReachesWhoAsksForTheStatusAtOnce) {
  InProcessRig rig;
  auto server = rig.serve();
  auto screen = rig.connect("screen"), asking = rig.connect("status");
  const auto told = [&](const ClientFigures& figures) {
    asking->ask_status();
    if (!asking->status()) return false;
    for (const auto& client : asking->status()->clients)
      if (client.name == "screen") return same_trouble(client.figures, figures);
    return false;
  };
  ClientFigures figures{.frames = 1};
  screen->tell(figures);
  const std::vector<StateLink*> links{screen.get(), asking.get()};
  ASSERT_TRUE(rig.until(links, [&] { return told(ClientFigures{}); }));
  for (int moment = 0; moment < 5; ++moment) {
    ++figures.frames;
    figures.conditions.clear();
    if (moment % 2 == 0)
      figures.conditions = {{device::HealthCode::camera_silent, 0.1 * moment, "camera: no image"}};
    screen->tell(figures);
    const auto begun = rig.network.now();
    ASSERT_TRUE(rig.until(links, [&] { return told(figures); }));
    EXPECT_LT(to_seconds(rig.network.now() - begun), 0.005) << moment;
    for (int ms = 0; ms < 37; ++ms) {
      rig.wait_a_little();
      for (auto* link : links) link->poll();
    }
  }
}

TEST(InProcessNetwork, TheRoundTripIsTheModelsDelayTwice) {
  InProcessRig rig({.delay = std::chrono::microseconds(700), .jitter = Duration(0)});
  auto server = rig.serve();
  auto link = rig.connect();
  link->request(1, {seconds(1)});
  rig.wait_a_little();
  link->poll();
  EXPECT_FALSE(link->newest().has_value());  // 1.4 ms have not passed
  rig.wait_a_little();
  link->poll();
  ASSERT_TRUE(link->newest().has_value());
  // Stamped when it came, not when it was looked at.
  EXPECT_EQ(link->newest()->received - link->newest()->sent, std::chrono::microseconds(1400));
}

TEST(InProcessNetwork, ClockStampsShowBothClocksAtTheMomentOfPassage) {
  InProcessRig rig({.delay = std::chrono::microseconds(300), .jitter = Duration(0)});
  auto server = rig.serve();
  auto link = rig.connect();
  ASSERT_TRUE(link->send_sync());
  rig.wait_a_little();
  link->poll();
  const auto stamps = link->take_sync();
  ASSERT_TRUE(stamps.has_value());
  // The rig's clocks read true time + 7 s and + 100 s; true time started at 0.
  EXPECT_EQ(stamps->t1.ns(), 7'000'000'000);
  EXPECT_EQ(stamps->t2.ns(), 100'000'300'000);
  EXPECT_EQ(stamps->t3.ns(), 100'000'300'000);
  EXPECT_EQ(stamps->t4.ns(), 7'000'600'000);
  EXPECT_FALSE(link->take_sync().has_value());
}

TEST(InProcessNetwork, LossIsCountedAndNothingElse) {
  const Play run = play({.loss = 0.1}, 2, 2000);
  // A request is lost if either way loses it: 1 - 0.9^2 = 0.19; sd of the count sqrt(2000 * 0.19 * 0.81)
  // = 17.5.
  EXPECT_NEAR(static_cast<double>(run.counters.lost), 380.0, 4 * 17.5);
  EXPECT_EQ(run.counters.lost + run.counters.frames_in_time, 2000u);
  EXPECT_EQ(run.counters.late + run.counters.duplicated + run.counters.out_of_order, 0u);
}

TEST(InProcessNetwork, DuplicatesAreCountedAndUsedOnce) {
  const Play run = play({.duplication = 0.1}, 3, 2000);
  // A doubled request is answered twice and each answer may double: the mean is 1.1^2 - 1 = 0.21 per request,
  // variance about 0.22; sd of the sum sqrt(2000 * 0.22) = 21.
  EXPECT_NEAR(static_cast<double>(run.counters.duplicated), 420.0, 4 * 21.0);
  EXPECT_EQ(run.counters.replies, 2000u);
  EXPECT_EQ(run.counters.frames_in_time, 2000u);
}

TEST(InProcessNetwork, WhatIsHeldBackIsLateAndOvertaken) {
  const Play run = play({.reordering = 0.1}, 4, 2000);
  // Held back by 40 ms one way or the other: after its frame is drawn (20 ms) and after the next reply (33
  // ms).
  EXPECT_NEAR(static_cast<double>(run.counters.late), 380.0, 4 * 17.5);
  EXPECT_GT(run.counters.out_of_order, 200u);
  EXPECT_LE(run.counters.out_of_order, run.counters.late);
  EXPECT_EQ(run.counters.lost, 0u);
}

TEST(InProcessNetwork, ADeadServerIsNoticedWithinASecond) {
  InProcessRig rig;
  auto server = rig.serve();
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));
  server->reset();
  const auto died = rig.network.now();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return !link->peer_alive(); }));
  EXPECT_LT(rig.network.now() - died, std::chrono::seconds(1));
}

TEST(InProcessNetwork, ALoopThatStoppedForALongTimeDoesNotTakeItsPeerForDead) {
  InProcessRig rig;
  auto server = rig.serve();
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));
  rig.network.advance_to(rig.network.now() + std::chrono::seconds(30));
  EXPECT_TRUE(link->peer_alive());
  link->poll();
  EXPECT_TRUE(link->peer_alive());
}

TEST(InProcessNetwork, AWishSurvivesABadWireAndAnOldOneIsDropped) {
  InProcessRig rig({.loss = 0.4, .duplication = 0.3, .reordering = 0.3}, 9);
  auto server = rig.serve();
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));
  int served = 0;
  for (int i = 0; i < 20; ++i) {
    link->send_control(scene::Control::begin);
    rig.until(
        {link.get()},
        [&] {
          while ((*server)->take_control()) ++served;
          return false;
        },
        std::chrono::seconds(3));
  }
  EXPECT_EQ(served + static_cast<int>(link->controls_dropped()), 20);
  EXPECT_GE(served, 18);  // ten tries each at a chance of 0.6 to arrive: 1e-4 to fail, plus answers lost

  server->reset();
  link->send_control(scene::Control::begin);
  EXPECT_FALSE(rig.until(
      {link.get()}, [] { return false; }, std::chrono::seconds(3)));
  server = rig.serve();
  EXPECT_TRUE(rig.until({link.get()}, [&] { return (*server)->counters().clients == 1; }));
  EXPECT_FALSE((*server)->take_control().has_value());
}

TEST(InProcessNetwork, LinksAndServicesMayOutliveTheNetwork) {
  auto network = std::make_unique<InProcessNetwork>(
      ChannelModel{}, 1, [](Instant<TrueTime> t) { return Instant<PhysicsClock>{t.since_epoch}; },
      [](Instant<TrueTime> t) { return Instant<GraphicsClock>{t.since_epoch}; });
  auto server = network->serve(testing::state_at, testing::table_scene());
  auto link = network->connect();
  network.reset();
  link->poll();
  EXPECT_FALSE(link->peer_alive());
}

}  // namespace
}  // namespace palpate::transport
