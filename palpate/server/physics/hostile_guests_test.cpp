// Applications that misbehave, and loops that guests have taken, around a physics server whose arm tells what
// it is commanded: forces are gone in time, and the culprit is named. On a virtual clock, but for the one test
// that the watchdog's thread really acts.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <thread>

#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/server/physics/guest_news.h"
#include "palpate/server/physics/loop_watchdog.h"
#include "palpate/server/physics/physics_server.h"

namespace palpate::server::physics {
namespace {

constexpr double kAsked = 1.3;  // N

struct ToldLaw : scene::ContactLaw {
  Vector3 force(const scene::TipState&, double) noexcept override {
    told();
    return {0.0, kAsked, 0.0};
  }
  double force_bound() const override { return 5.0; }
  Duration cost_bound() const override { return std::chrono::microseconds(100); }
  std::function<void()> told = [] {};
};

class ToldApplication : public scene::Application {
 public:
  void step(Instant<PhysicsClock>, Duration, const scene::TipState&, scene::SceneState& state) override {
    ++steps;
    state.continuous.force = {0.0, kAsked, 0.0};
    told(state);
  }
  const scene::ImpactEvent& impact() const override { return impact_; }
  scene::ContactLaw* contact_law() override { return law; }
  std::function<void(scene::SceneState&)> told = [](auto&) {};
  std::function<void()> told_on_reset = [] {};
  scene::ContactLaw* law = nullptr;
  int steps = 0;

 private:
  void begin() override {}
  void reset() override { told_on_reset(); }
  scene::ImpactEvent impact_;
};

struct GuestBench {
  explicit GuestBench(scene::ContactLaw* law = nullptr) {
    auto made = std::make_unique<ToldApplication>();
    made->law = law;
    application = made.get();
    rig::Rig rig;
    rig.arm = haptics::bench_calibration();
    scene::SceneDescription scene;
    scene.application = "guest";
    arm.sample.joints = {0.1, 0.5, 0.3};
    server.emplace(rig, scene, std::move(made), arm, haptics::without_ramp());
  }
  void haptic_tick() {
    now += std::chrono::milliseconds(1);
    server->haptic_tick(now);
  }
  void live(int ms) {
    for (int i = 0; i < ms; ++i) {
      haptic_tick();
      server->physics_tick(now);
    }
  }
  std::string forces_text() const {
    const haptics::HapticCondition condition = server->haptic().condition();
    transport::LoopStatus status;
    status.forces = device::ForceCondition{condition.state, condition.fault};
    status.culprit = server->culprit();
    return status.forces_text();
  }
  // How many ms until there is no force; all steps within the slew limit.
  int gone_after(int at_most, const std::function<void()>& ms) {
    EXPECT_GT(arm.force.norm(), 1.0);
    arm.steepest = 0.0;
    for (int i = 1; i <= at_most; ++i) {
      ms();
      if (arm.force.norm() > 0.0) continue;
      EXPECT_LE(arm.steepest, 3.0 + 1e-9);
      return i;
    }
    return -1;
  }
  haptics::FakeArm arm;
  ToldApplication* application;
  std::optional<PhysicsServer> server;
  Instant<PhysicsClock> now = Instant<PhysicsClock>::from_seconds(1.0);
};

TEST(AHostileApplication, ThatThrowsIsNotCalledAgainAndItsForceFades) {
  GuestBench bench;
  bench.live(50);
  bench.application->told = [](auto&) { throw std::runtime_error("no more levels"); };
  const int gone = bench.gone_after(60, [&] { bench.live(1); });
  EXPECT_GT(gone, 0);
  EXPECT_LE(gone, 20 + 1);
  EXPECT_EQ(bench.application->steps, 51);
  EXPECT_TRUE(bench.server->state_at(bench.now - std::chrono::milliseconds(gone + 1)).usable())
      << "the server goes on answering";
  EXPECT_EQ(
      bench.server->trouble(),
      "the application 'guest' threw: no more levels; it is not called again and forces stay off until the "
      "server is started anew");
  EXPECT_EQ(bench.forces_text(), "degraded: stale input (guest)");
  bench.server->control(scene::Control::reset);
  bench.live(2000);
  EXPECT_EQ(bench.arm.force, Vector3::Zero());
}

TEST(AHostileApplication, ThatThrowsAtAPersonsWishOrThrowsNoExceptionIsTheSame) {
  GuestBench bench;
  bench.live(50);
  bench.application->told_on_reset = [] { throw 7; };
  bench.server->control(scene::Control::reset);
  EXPECT_LE(bench.gone_after(60, [&] { bench.live(1); }), 20 + 1);
  EXPECT_NE(bench.server->trouble().find("guest"), std::string::npos);
}

TEST(AHostileApplication, ThatNeverReturnsFromItsStepLosesItsForceIn20Ms) {
  GuestBench bench;
  bench.live(50);
  EXPECT_LE(bench.gone_after(60, [&] { bench.haptic_tick(); }), 20);
  EXPECT_EQ(bench.forces_text(), "degraded: stale input (guest)");
}

TEST(AHostileApplication, ThatSleeps10MsInEachStepHasNoForceAndIsNamed) {
  GuestBench bench;
  bench.live(50);
  // What its step says arrives 10 ms after the moment it is of.
  const auto slow = [&] {
    const Instant<PhysicsClock> begun = bench.now;
    for (int i = 0; i < 10; ++i) bench.haptic_tick();
    bench.server->physics_tick(begun);
  };
  EXPECT_LE(bench.gone_after(6, slow), 3);
  for (int i = 0; i < 100; ++i) {
    slow();
    ASSERT_EQ(bench.arm.force, Vector3::Zero());
  }
  EXPECT_EQ(bench.forces_text(), "degraded: stale input (guest)");
}

TEST(AHostileApplication, ThatAsksForNoNumberOr1kNLosesItsForceAndIsNamed) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1000.0}) {
    GuestBench bench;
    bench.live(50);
    bench.application->told = [&](scene::SceneState& state) { state.continuous.force[0] = bad; };
    const int gone = bench.gone_after(60, [&] { bench.live(1); });
    EXPECT_GT(gone, 0) << bad;
    EXPECT_LE(gone, 20) << bad;
    EXPECT_EQ(bench.forces_text(), "degraded: force beyond reason (guest)");
  }
}

TEST(LoopWatch, AnArmWhoseLoopHangsIsToldToLetGoWithin30Ms) {
  for (int phase = 0; phase < 4; ++phase) {
    GuestBench bench;
    LoopWatch watch(bench.server->haptic());
    for (int i = 0; i < 50; ++i) {
      bench.live(1);
      if (i % 4 == phase) {
        EXPECT_FALSE(watch.look(bench.now));
      }
    }
    ASSERT_GT(bench.arm.force.norm(), 1.0);
    int gone = -1;
    for (int ms = 1; ms <= 60 && gone < 0; ++ms) {
      bench.now += std::chrono::milliseconds(1);
      if ((50 + ms - 1) % 4 == phase) watch.look(bench.now);
      if (bench.arm.force == Vector3::Zero()) gone = ms;
    }
    EXPECT_GT(gone, 0);
    EXPECT_LE(gone, 30) << phase;
    // It comes back: from nothing, as after any outage.
    bench.live(1);
    EXPECT_EQ(bench.arm.force, Vector3::Zero());
    EXPECT_FALSE(watch.look(bench.now));
    bench.live(60);
    EXPECT_NEAR(bench.arm.felt(haptics::bench_calibration()).norm(), kAsked, 1e-6);
  }
}

TEST(LoopWatchdog, ActsWhileTheLoopsThreadHangsInAContactLaw) {
  ToldLaw law;
  std::atomic<bool> hanging{false}, released{false};
  law.told = [&] {
    if (!hanging) return;
    hanging.wait(true);
    released = true;
  };
  MonotonicClock<PhysicsClock> clock;
  std::atomic<bool> stop{false}, pressed{false};
  struct Told : device::ArmDevice {
    device::ArmSample read() override { return {Instant<ArmClock>{}, {0.1, 0.5, 0.3}}; }
    void command(const Vector3&) override {}
    void let_go() noexcept override { times.fetch_add(1); }
    std::atomic<int> times{0};
  } arm;
  TripleBuffer<haptics::HapticInput> input;
  TripleBuffer<scene::TipState> output;
  haptics::HapticLoop loop(arm, haptics::bench_calibration(), {}, haptics::bench_settings(), input, output,
                           {"guest", &law, nullptr});
  std::thread ticking([&] {
    while (!stop) {
      loop.tick(clock.now());
      if (loop.ticks_ended() > 10) pressed = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  LoopWatchdog watchdog(clock, loop, false);
  while (!pressed) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const int before = arm.times;
  hanging = true;
  while (arm.times == before || !watchdog.hangs()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(loop.name_of(loop.busy_with()), "the contact law of 'guest'");
  EXPECT_FALSE(released);
  EXPECT_GE(watchdog.times(), 1u);
  hanging = false;
  hanging.notify_all();
  while (watchdog.hangs()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  stop = true;
  ticking.join();
}

TEST(GuestNews, ThatALoopDoesNotComeBackIsToldByNameAndEndsTheServer) {
  ToldLaw law;
  GuestBench bench(&law);
  GuestNews news;
  for (int i = 0; i < 200; ++i) {
    bench.live(20);
    EXPECT_EQ(news.look(*bench.server, false).text, "");
  }
  // The step does not come back.
  std::vector<std::string> lines;
  bool last = false;
  for (int i = 0; i < 200 && !last; ++i) {
    for (int k = 0; k < 20; ++k) bench.haptic_tick();
    const auto line = news.look(*bench.server, false);
    if (!line.text.empty()) lines.push_back(line.text);
    last = line.last;
  }
  ASSERT_TRUE(last);
  EXPECT_EQ(lines.back(), "the application 'guest' does not come back; the server ends");
  EXPECT_EQ(lines.front(), "the application 'guest' does not come back; forces are off");
  // The law does not.
  law.told = [&] {
    GuestNews other;
    std::string text;
    bool ended = false;
    for (int i = 0; i < GuestNews::kGivenUp; ++i) {
      const auto line = other.look(*bench.server, true);
      if (!line.text.empty()) text = line.text;
      ended = line.last;
    }
    EXPECT_TRUE(ended);
    EXPECT_EQ(text, "the contact law of 'guest' does not come back; the server ends");
    law.told = [] {};
  };
  bench.haptic_tick();
}

TEST(GuestNews, ADriverThatNeverComesBackFromItsFirstCallIsToldAndEndsTheServer) {
  GuestBench bench;  // no tick has ended yet
  GuestNews news;
  int looks = 0;
  for (bool last = false; !last && looks < 1000; ++looks) last = news.look(*bench.server, false).last;
  EXPECT_EQ(looks, GuestNews::kGivenUp);
  EXPECT_TRUE(news.hang());
  bench.live(20);
  EXPECT_EQ(news.look(*bench.server, false).text, "");
  EXPECT_FALSE(news.hang());
}

TEST(GuestNews, WhoTakesTheForcesAwayIsToldOnceUntilItHeals) {
  GuestBench bench;
  bench.live(50);
  GuestNews news;
  const auto lines = [&](int looks) {
    std::vector<std::string> told;
    for (int i = 0; i < looks; ++i) {
      bench.live(20);
      if (const auto line = news.look(*bench.server, false); !line.text.empty()) told.push_back(line.text);
    }
    return told;
  };
  EXPECT_TRUE(lines(50).empty());
  bench.application->told = [](scene::SceneState& state) { state.continuous.force[2] = std::nan(""); };
  EXPECT_EQ(lines(100),
            std::vector<std::string>{"forces are off: force beyond reason: the application 'guest'"});
  bench.application->told = [](auto&) {};
  EXPECT_TRUE(lines(100).empty());
  bench.application->told = [](auto&) { throw std::runtime_error("enough"); };
  const auto told = lines(100);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("the application 'guest' threw: enough"), std::string::npos);
}

TEST(GuestNews, ADriverThatLosesItsArmWithoutAWordIsNamed) {
  GuestBench bench;
  bench.live(50);
  bench.arm.sample.connected = false;  // as where it throws
  GuestNews news;
  std::vector<std::string> told;
  for (int i = 0; i < 200; ++i) {
    bench.live(20);
    if (const auto line = news.look(*bench.server, false); !line.text.empty()) told.push_back(line.text);
  }
  EXPECT_EQ(told, std::vector<std::string>{"forces are off: arm lost: the arm's driver"});
}

TEST(GuestNews, ALawThatIsSwitchedOffIsNamedAlsoWhereItsFirstFaultWouldHaveHealed) {
  struct NoNumber : ToldLaw {
    Vector3 force(const scene::TipState&, double) noexcept override { return {0.0, asked, 0.0}; }
    double asked = kAsked;
  } law;
  GuestBench bench(&law);
  bench.live(50);
  law.asked = std::nan("");
  GuestNews news;
  std::vector<std::string> told;
  for (int i = 0; i < 200; ++i) {
    bench.live(20);
    if (const auto line = news.look(*bench.server, false); !line.text.empty()) told.push_back(line.text);
  }
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0], "forces are off: " + std::string(device::name_of(device::ForceFault::law_failed)) +
                         ": the contact law of 'guest'");
}

}  // namespace
}  // namespace palpate::server::physics
