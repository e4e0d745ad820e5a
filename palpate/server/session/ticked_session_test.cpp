// The laboratory's devices in a session on the virtual clock, put together by URI; no window, no lock-step's book-keeping.
#include "palpate/server/session/ticked_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/specification.h"
#include "palpate/device/borrowed_devices.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/simulator.h"
#include "palpate/sim/truth_rig.h"

namespace palpate::server::session {
namespace {

struct Play {
  std::size_t frames = 0, late = 0;
  double worst_tip_mm = 0.0, worst_sync_us = 0.0;
  scene::SceneState last;
};

SessionSetup setup_of(sim::Simulator& world,
                      const device::ArmFacts& arm = {
                          .simulated = true, .identity = "mine", .peak_n = {}, .continuous_n = {}}) {
  SessionSetup setup;
  setup.physics.rig = sim::truth_rig(world);
  setup.physics.applications = {applications::pingpong::specification()};
  setup.physics.scene = *sim::config::scene_of(world.file(), setup.physics.applications, "pingpong");
  setup.physics.drivers.add(device::borrowed_devices("mine", {.arm = &world.arm(),
                                                              .arm_facts = arm,
                                                              .tracker = &world.tracker(),
                                                              .camera = &world.camera(),
                                                              .hand = &world.hand(),
                                                              .simulated = true}));
  setup.physics.arm.uri = "mine";
  setup.graphics.world = world.file();
  setup.graphics.stand_in = "mine";
  setup.graphics.pixels = Pixels::unseen;
  setup.graphics.player = true;
  return setup;
}

Play play(std::uint64_t seed, double seconds_played, const transport::ChannelModel& channel = {}) {
  sim::Simulator world(sim::config::reference_world(), seed);
  world.begin_play();
  VirtualTime time;
  time.begin = world.now();
  time.graphics = [&world](Instant<TrueTime> t) { return world.graphics_clock().at(t); };
  time.channel = channel;
  auto opened = TickedSession::open(setup_of(world), time);
  EXPECT_TRUE(opened) << opened.error().message;
  if (!opened) return {};
  TickedSession& session = **opened;
  EXPECT_TRUE(world.person().ask({device::Gesture::look, "", 0}));
  std::map<std::int64_t, Vector3> tips;  // where the stylus truly was
  Play result;
  for (auto t = world.now(); to_seconds(t - time.begin) < seconds_played; t += std::chrono::milliseconds(1)) {
    world.advance_to(t);
    tips[t.ns()] = world.true_state().X_world_tip.translation;
    session.tick_physics(t);
    const graphics::FrameRecord* frame = session.tick_graphics(t);
    if (frame == nullptr || !frame->have_state || to_seconds(t - time.begin) < 2.0) continue;
    ++result.frames;
    result.late += frame->late ? 1 : 0;
    result.last = frame->state;
    const double sync_us = 1e6 * to_seconds(session.graphics().server().sync().model().to(time.graphics(t)) -
                                            Instant<PhysicsClock>{t.since_epoch});
    result.worst_sync_us = std::max(result.worst_sync_us, std::abs(sync_us));
    const auto truth = tips.lower_bound(frame->state.time.ns());
    if (truth != tips.end())
      result.worst_tip_mm =
          std::max(result.worst_tip_mm,
                   1e3 * (scene::shown_tip(frame->state, session.graphics().scene()) - truth->second).norm());
  }
  return result;
}

TEST(TickedSession, PlaysWithTheLaboratorysDevicesAndShowsTheTipWhereItTrulyWas) {
  const Play p = play(3, 12.0);
  EXPECT_GT(p.frames, 250u) << "thirty a second, ten seconds";
  EXPECT_EQ(p.late, 0u) << "the channel's 0.15 ms are far below the drawing time";
  EXPECT_LT(p.worst_sync_us, 50.0) << "although the graphics host's clock is off and drifts";
  // The tracker says nothing of the tip: it is the arm's, whose samples are as old as the tick, at up to 3 m/s.
  EXPECT_LT(p.worst_tip_mm, 6.0);
  EXPECT_GT(p.last.counters[applications::pingpong::kServes], 5);
  EXPECT_GT(p.last.counters[applications::pingpong::kReturned], 2) << "the player sees, and leads the hand";
}

TEST(TickedSession, IsTheSameToTheBitForTheSameSeedAndFeelsItsChannel) {
  const Play a = play(4, 4.0), b = play(4, 4.0);
  EXPECT_EQ(a.frames, b.frames);
  EXPECT_EQ(a.worst_sync_us, b.worst_sync_us);
  EXPECT_EQ(a.last.bodies[0].position, b.last.bodies[0].position);
  EXPECT_GT(play(4, 4.0, {.delay = std::chrono::milliseconds(15)}).late, 20u)
      << "replies come after the drawing";
}

TEST(TickedSession, ARigWithoutWhatASideNeedsIsRefused) {
  sim::Simulator world(sim::config::reference_world(), 1);
  SessionSetup setup = setup_of(world);
  setup.physics.rig.arm.reset();
  const auto session = TickedSession::open(setup, {});
  ASSERT_FALSE(session);
  EXPECT_NE(session.error().message.find("arm calibration"), std::string::npos);
  // A virtual clock limits no force of an arm that somebody holds.
  const SessionSetup real =
      setup_of(world, {.simulated = false, .identity = "maker 7", .peak_n = {}, .continuous_n = {}});
  const auto held = TickedSession::open(real, {});
  ASSERT_FALSE(held);
  EXPECT_NE(held.error().message.find("is no computed one"), std::string::npos) << held.error().message;
  SessionSetup no_hand = setup_of(world);
  no_hand.physics.drivers = {};
  EXPECT_FALSE(TickedSession::open(no_hand, {}));
}

}  // namespace
}  // namespace palpate::server::session
