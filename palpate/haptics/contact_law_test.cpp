// A contact law in the haptic tick: that its force answers to the tip just read, and what becomes of a law
// that breaks its promises, on a clock that moves as the test says.
#include "palpate/scene/contact_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "palpate/haptics/haptic_bench_test.h"
#include "tests/allocation_count.h"

namespace palpate::haptics {
namespace {

constexpr double kAsked = 1.3;  // N, just below what motors can hold for ever

struct FakeThreadClock : ThreadClock {
  ThreadTime now() const noexcept override { return time; }
  ThreadTime time;
};

// Does as it is told.
struct ToldLaw : scene::ContactLaw {
  Vector3 force(const scene::TipState& tip, double dt) noexcept override {
    ++calls;
    last_dt = dt;
    return told(tip);
  }
  double force_bound() const override { return bound_n; }
  Duration cost_bound() const override { return cost; }
  std::function<Vector3(const scene::TipState&)> told = [](const auto&) { return Vector3(0.0, kAsked, 0.0); };
  double bound_n = 20.0, last_dt = 0.0;
  Duration cost = std::chrono::microseconds(300);
  int calls = 0;
};

struct LawBench {
  LawBench() {
    arm.sample.joints = {0.1, 0.5, 0.3};
    arm.sample.gimbal = {0.2, -0.1, 0.3};
    arm.lets_go = true;
  }
  // The time that guests take passes for everybody.
  void live() {
    now += std::max(settings.period, busy);
    busy = Duration(0);
    message.time = now;
    input.write(message);
    const Duration before = clock.time.wall;
    loop.tick(now);
    busy = clock.time.wall - before;
    // As a device does when no command has come for long.
    if (busy > device::kLongestHold) arm.let_go();
  }
  void live(int ticks) {
    for (int i = 0; i < ticks; ++i) live();
  }
  void work(Duration time) { clock.time.wall += time, clock.time.cpu += time; }
  void sleep(Duration time) { clock.time.wall += time, ++clock.time.waits; }
  void lose_the_core(Duration time) { clock.time.wall += time; }
  double felt() const { return arm.felt(calibration).norm(); }

  HapticSettings settings = without_ramp();
  FakeThreadClock clock;
  ToldLaw law;
  rig::ArmCalibration calibration = bench_calibration();
  FakeArm arm;
  TripleBuffer<HapticInput> input;
  TripleBuffer<scene::TipState> output;
  HapticInput message;
  Instant<PhysicsClock> now;
  Duration busy{0};  // what the tick before took
  HapticLoop loop{arm, calibration, {}, settings, input, output, {"guest", &law, &clock}};
};

TEST(ContactLawInTheTick, ItsForceAnswersToTheTipJustReadAndTheStepsForceIsNotGiven) {
  LawBench bench;
  bench.message.continuous = {5.0, 5.0, 5.0};
  Vector3 seen = Vector3::Zero();
  bench.law.told = [&](const scene::TipState& tip) {
    seen = tip.X_world_tip.translation;
    return Vector3(0.0, -100.0 * (seen.y() + 1.3),
                   0.0);  // a spring: the observer of passivity has nothing to do
  };
  bench.live(10);
  for (int i = 0; i < 50; ++i) {
    bench.arm.sample.joints[1] += 1e-4;
    const double before = bench.felt();
    bench.live();
    EXPECT_EQ(seen, bench.loop.tip().X_world_tip.translation) << "of this very tick";
    EXPECT_NEAR(bench.felt(), 100.0 * (seen.y() + 1.3), 1e-6);
    EXPECT_NE(bench.felt(), before);
  }
  EXPECT_NEAR(bench.law.last_dt, 1e-3, 1e-12);
  EXPECT_EQ(bench.loop.statistics().law_ticks, 60u);
  EXPECT_EQ(bench.loop.statistics().law_overruns, 0u);
}

TEST(ContactLawInTheTick, ItIsNotAskedBeforeTheArmHasBeenSeen) {
  LawBench bench;
  bench.arm.sample.joints.setConstant(std::nan(""));
  bench.live(5);
  EXPECT_EQ(bench.law.calls, 0);
}

TEST(ContactLawInTheTick, DelayedOnPurposeItsForceComesSoMuchLater) {
  LawBench bench;
  bench.loop.delay_law(std::chrono::milliseconds(40));
  bench.law.told = [](const auto&) { return Vector3(0.0, 0.0, 0.0); };
  bench.live(50);
  bench.law.told = [](const auto&) { return Vector3(0.0, kAsked, 0.0); };
  bench.live(40);
  EXPECT_EQ(bench.felt(), 0.0);
  bench.live(1);
  EXPECT_NEAR(bench.felt(), kAsked, 1e-9);
}

TEST(ContactLawInTheTick, ALawThatPromisesNothingIsRefusedByName) {
  const auto refusal = [](double bound_n, Duration cost) -> std::string {
    LawBench bench;
    ToldLaw law;
    law.bound_n = bound_n;
    law.cost = cost;
    try {
      const HapticLoop loop(bench.arm, bench.calibration, {}, {}, bench.input, bench.output,
                            {"guest", &law, nullptr});
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "";
  };
  const Duration quick = std::chrono::microseconds(1);
  EXPECT_EQ(refusal(1.0, quick), "");
  EXPECT_NE(refusal(0.0, quick).find("guest: the contact law promises 0 N"), std::string::npos);
  EXPECT_NE(refusal(std::nan(""), quick).find("guest: the contact law promises nan N"), std::string::npos);
  EXPECT_NE(refusal(1.0, Duration(0)).find("guest: the contact law promises to take 0 ns"),
            std::string::npos);
}

// From the moment the law misbehaves: never a larger step than the slew, nothing after 25 ms, and never again.
struct LawFall {
  int gone = -1;  // ms
  bool stays_off = true;
};
template <typename Misbehave>
LawFall fall_of(LawBench& bench, Misbehave misbehave) {
  bench.live(50);
  EXPECT_NEAR(bench.felt(), kAsked, 1e-9);
  bench.arm.steepest = 0.0;
  const Instant<PhysicsClock> begun = bench.now;
  bench.law.told = misbehave;
  LawFall fall;
  for (int i = 0; i < 300; ++i) {
    bench.live();
    if (bench.felt() == 0.0 && fall.gone < 0)
      fall.gone = static_cast<int>(1e3 * to_seconds(bench.now + bench.busy - begun) + 0.5);
    if (fall.gone >= 0 && bench.felt() > 0.0) fall.stays_off = false;
  }
  EXPECT_LE(bench.arm.steepest, 3.0 + 1e-9);
  EXPECT_TRUE(bench.arm.finite);
  return fall;
}

TEST(AHostileLaw, ThatSleeps10MsInEachTickLosesItsForceAndIsNamed) {
  LawBench bench;
  const LawFall fall = fall_of(bench, [&](const auto&) {
    bench.sleep(std::chrono::milliseconds(10));
    return Vector3(0.0, kAsked, 0.0);
  });
  EXPECT_GT(fall.gone, 0);
  EXPECT_LE(fall.gone, 35) << "it keeps the loop from acting for 10 ms at a time";
  EXPECT_TRUE(fall.stays_off);
  EXPECT_EQ(bench.loop.fault(), ForceFault::law_failed);
  EXPECT_EQ(bench.loop.state(), ForceState::safe);
  EXPECT_EQ(bench.loop.name_of(bench.loop.condition().culprit), "the contact law of 'guest'");
  EXPECT_LT(bench.law.calls, 50 + 20) << "switched off: it is not called any more";
}

TEST(AHostileLaw, ThatComputesForTooLongIsSwitchedOffAndOnAgainByAPerson) {
  LawBench bench;
  const LawFall fall = fall_of(bench, [&](const auto&) {
    bench.work(std::chrono::microseconds(400));  // promised: 300
    return Vector3(0.0, kAsked, 0.0);
  });
  EXPECT_GT(fall.gone, 10) << "a few times are forgiven";
  EXPECT_LE(fall.gone, 30);
  EXPECT_TRUE(fall.stays_off);
  EXPECT_EQ(bench.loop.condition().trip_fault, ForceFault::law_failed);
  EXPECT_EQ(bench.loop.condition().trip_culprit, Guest::contact_law);
  bench.law.told = [](const auto&) { return Vector3(0.0, kAsked, 0.0); };
  bench.live(50);
  EXPECT_EQ(bench.felt(), 0.0);
  EXPECT_TRUE(bench.loop.rearm());
  bench.live(50);
  EXPECT_NEAR(bench.felt(), kAsked, 1e-9);
}

TEST(AHostileLaw, IsNotBlamedWhereTheMachineTookItsCoreAway) {
  LawBench bench;
  bench.live(50);
  bench.law.told = [&](const auto&) {
    bench.lose_the_core(std::chrono::microseconds(900));
    return Vector3(0.0, kAsked, 0.0);
  };
  bench.live(200);
  EXPECT_EQ(bench.loop.state(), ForceState::running);
  EXPECT_NEAR(bench.felt(), kAsked, 1e-9);
  EXPECT_EQ(bench.loop.statistics().law_overruns, 0u);
}

TEST(AHostileLaw, ThatIsSlowNowAndThenIsForgiven) {
  LawBench bench;
  int call = 0;
  bench.law.told = [&](const auto&) {
    if (++call % 200 == 0) bench.work(std::chrono::microseconds(600));
    return Vector3(0.0, kAsked, 0.0);
  };
  bench.live(20'000);
  EXPECT_EQ(bench.loop.fault(), ForceFault::none);
  EXPECT_NEAR(bench.felt(), kAsked, 1e-9);
  EXPECT_EQ(bench.loop.statistics().law_overruns, 100u);
}

TEST(AHostileLaw, ThatAsksForNoNumberOrForMoreThanItPromisedLosesItsForceAtOnce) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1000.0, 20.1}) {
    LawBench bench;
    const LawFall fall = fall_of(bench, [&](const auto&) { return Vector3(0.0, bad, 0.0); });
    EXPECT_GT(fall.gone, 0) << bad;
    EXPECT_LE(fall.gone, 20) << bad;
    EXPECT_TRUE(fall.stays_off) << bad;
    EXPECT_EQ(bench.loop.fault(), ForceFault::law_failed) << "again and again: it is off";
    EXPECT_EQ(bench.loop.condition().culprit, Guest::contact_law);
    EXPECT_GE(bench.loop.statistics().law_bad_forces, 10u);
  }
}

TEST(AHostileLaw, ThatErrsOnceIsNamedAndComesBackByTheRule) {
  LawBench bench;
  bench.live(50);
  bench.law.told = [](const auto&) { return Vector3(1000.0, 0.0, 0.0); };
  bench.live();
  EXPECT_EQ(bench.loop.fault(), ForceFault::bad_force);
  EXPECT_EQ(bench.loop.condition().culprit, Guest::contact_law);
  EXPECT_LT(bench.felt(), kAsked);
  bench.law.told = [](const auto&) { return Vector3(0.0, kAsked, 0.0); };
  bench.live(60);
  EXPECT_NEAR(bench.felt(), kAsked, 1e-9);
}

// One tick in which it takes long: forces fade from what the device still holds, and come back by the rule.
TEST(AHostileLaw, ThatTakesLongOnceBeginsAnOutage) {
  for (const int ms : {5, 12, 30, 45, 300}) {
    LawBench bench;
    bench.live(50);
    bench.arm.steepest = 0.0;
    bench.law.told = [&](const auto&) {
      bench.sleep(std::chrono::milliseconds(ms));
      if (ms > 20) bench.arm.let_go();
      return Vector3(0.0, kAsked, 0.0);
    };
    bench.live();
    EXPECT_LT(bench.felt(), kAsked) << ms;
    if (ms > 20) {
      EXPECT_EQ(bench.felt(), 0.0) << ms << ": the device has let go, and what the tick knew is old";
    }
    bench.law.told = [](const auto&) { return Vector3(0.0, kAsked, 0.0); };
    bench.live(60);
    EXPECT_NEAR(bench.felt(), kAsked, 1e-6) << ms;
    EXPECT_LE(bench.arm.steepest, 3.0) << ms;
    EXPECT_EQ(bench.loop.statistics().law_overruns, 1u);
  }
}

TEST(AHostileLaw, NeverReturnsAndWhatComesAfterTheArmWasToldToLetGoBeginsWithNoForce) {
  LawBench bench;
  bench.live(50);
  bench.law.told = [&](const auto&) {
    EXPECT_EQ(bench.loop.busy_with(), Guest::contact_law);
    bench.sleep(std::chrono::milliseconds(25));
    bench.loop.let_go();  // as the watchdog does from its thread
    EXPECT_EQ(bench.felt(), 0.0);
    return Vector3(0.0, kAsked, 0.0);
  };
  bench.arm.steepest = 0.0;
  bench.live();
  EXPECT_EQ(bench.felt(), 0.0);
  EXPECT_EQ(bench.loop.busy_with(), Guest::none);
  bench.law.told = [](const auto&) { return Vector3(0.0, kAsked, 0.0); };
  double before = 0.0;
  for (int i = 0; i < 50; ++i) {
    bench.live();
    EXPECT_LE(bench.felt() - before, 0.06 * kAsked) << "within 40 ms, evenly";
    before = bench.felt();
  }
  EXPECT_NEAR(bench.felt(), kAsked, 1e-6);
}

// A driver: as one that is no guest's fault, but its own.
struct ToldArm : FakeArm {
  device::ArmSample read() override {
    in_read();
    return FakeArm::read();
  }
  void command(const Vector3& asked) override {
    in_command();
    FakeArm::command(asked);
  }
  std::function<void()> in_read = [] {}, in_command = [] {};
};

struct DriverBench {
  DriverBench() { arm.sample.joints = {0.1, 0.5, 0.3}, message.continuous = {0.0, kAsked, 0.0}, live(50); }
  void live() {
    now += std::max(std::max(settings.period, busy), clock.time.wall - before);
    busy = Duration(0);
    message.time = now;
    input.write(message);
    before = clock.time.wall;
    loop.tick(now);
  }
  void live(int ticks) {
    for (int i = 0; i < ticks; ++i) live();
  }
  HapticSettings settings = without_ramp();
  FakeThreadClock clock;
  rig::ArmCalibration calibration = bench_calibration();
  ToldArm arm;
  TripleBuffer<HapticInput> input;
  TripleBuffer<scene::TipState> output;
  HapticInput message;
  Instant<PhysicsClock> now;
  Duration busy{0}, before{0};
  HapticLoop loop{arm, calibration, {}, settings, input, output, {"guest", nullptr, &clock}};
};

TEST(AHostileDriver, ThatSleeps10MsInEachTickHasNoForcesAndIsNamed) {
  for (const bool reading : {true, false}) {
    DriverBench bench;
    ASSERT_GT(bench.arm.force.norm(), 1.0);
    bench.arm.steepest = 0.0;
    (reading ? bench.arm.in_read : bench.arm.in_command) = [&] {
      bench.clock.time.wall += std::chrono::milliseconds(10);
      ++bench.clock.time.waits;
    };
    bench.live(100);
    EXPECT_EQ(bench.arm.force, Vector3::Zero());
    EXPECT_EQ(bench.loop.fault(), ForceFault::arm_slow);
    EXPECT_EQ(bench.loop.name_of(bench.loop.condition().culprit), "the arm's driver");
    EXPECT_LE(bench.arm.steepest, 3.0 + 1e-9);
  }
}

TEST(AHostileDriver, ThatThrowsIsAnArmThatIsLostAndNamed) {
  for (const bool reading : {true, false}) {
    DriverBench bench;
    (reading ? bench.arm.in_read : bench.arm.in_command) = [] { throw std::runtime_error("no cable"); };
    bench.live(2);
    EXPECT_EQ(bench.loop.fault(), ForceFault::arm_lost);
    EXPECT_EQ(bench.loop.condition().culprit, Guest::arm);
    bench.arm.in_read = bench.arm.in_command = [] {};
    bench.live(20);
    EXPECT_EQ(bench.arm.force, Vector3::Zero()) << "until a person resets";
    EXPECT_TRUE(bench.loop.rearm());
    bench.live(60);
    EXPECT_GT(bench.arm.force.norm(), 1.0);
  }
}

TEST(ContactLawInTheTick, AllocatesNothing) {
  LawBench bench;
  bench.live(10);
  const std::size_t before = allocations();
  for (int i = 0; i < 1000; ++i) {
    bench.arm.sample.joints[1] += 1e-5;
    bench.live();
  }
  EXPECT_EQ(allocations() - before, 0u);
}

}  // namespace
}  // namespace palpate::haptics
