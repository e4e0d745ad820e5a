// Ten million ticks of whatever can come in, bad numbers and all: what goes out is always a number, never
// above the device's peak, never faster than its slew. 200,000 ticks under sanitizers, which are slower.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "palpate/core/random.h"
#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/math/random_vector.h"
#include "tests/sanitized.h"

namespace palpate::haptics {
namespace {

#ifdef PALPATE_SANITIZED
constexpr int kTicks = 200'000;
#else
constexpr int kTicks = 10'000'000;
#endif

double bad_number(Random& random) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::array<double, 10> bad{std::nan(""), kInfinity, -kInfinity, 1e308,  -1e308,
                                   1e150,        1e6,       -1e6,       1e-310, 0.0};
  return bad[static_cast<std::size_t>(random.uniform(0.0, 9.999))];
}

TEST(HapticHostile, TenMillionTicksNeverBreakALimit) {
  Random random(7, "haptics/hostile");
  HapticSettings settings = without_ramp();
  settings.limits.continuous_n = 4.0;  // so that the peak is reached more often
  HapticBench bench(settings);
  FakeArm& arm = bench.arm;
  Vector3 velocity = Vector3::Zero();
  int running = 0, safe = 0, degraded = 0;
  double largest = 0.0;
  const double peak = settings.limits.peak_n * (1.0 + 1e-12), step = 3.0 * (1.0 + 1e-9);
  for (int i = 0; i < kTicks; ++i) {
    // Long calm stretches, so that forces are really on when something happens.
    const bool wild = random.chance(0.01);
    velocity = 0.99 * velocity + uniform3(random, 2e-4);
    arm.sample.joints = (arm.sample.joints + velocity).cwiseMax(-0.5).cwiseMin(1.2);
    if (!arm.sample.joints.allFinite()) arm.sample.joints = {0.1, 0.5, 0.3};
    arm.frozen = wild && random.chance(0.3);
    arm.sample.connected = !(wild && random.chance(0.02));
    if (random.chance(0.02)) bench.message.continuous = uniform3(random, random.chance(0.2) ? 30.0 : 3.0);
    if (random.chance(0.01)) {
      auto& impact = bench.message.impact;
      ++impact.number;
      impact.start = bench.now + seconds(random.uniform(-0.01, 0.01));
      impact.direction = normal3(random).normalized();
      impact.approach_speed = random.uniform(0.0, 30.0);
      impact.mass = 0.0027;
      impact.duration = seconds(random.uniform(0.0005, 0.01));
      impact.restitution = random.uniform(0.0, 1.0);
    }
    if (wild) {
      auto& impact = bench.message.impact;
      const int what = static_cast<int>(random.uniform(0.0, 11.999));
      const auto axis = static_cast<Eigen::Index>(random.uniform(0.0, 2.999));
      if (what == 0) arm.sample.joints[axis] = bad_number(random);
      if (what == 1) arm.sample.gimbal[axis] = bad_number(random);
      if (what == 2) bench.message.continuous[axis] = bad_number(random);
      if (what == 3) ++impact.number, impact.approach_speed = bad_number(random);
      if (what == 4) ++impact.number, impact.mass = bad_number(random);
      if (what == 5) ++impact.number, impact.direction[axis] = bad_number(random);
      if (what == 6) ++impact.number, impact.restitution = bad_number(random);
      if (what == 7) ++impact.number, impact.duration = Duration(random.chance(0.5) ? -1 : 1);
      if (what == 8) ++impact.number, impact.start = {Duration(std::numeric_limits<std::int64_t>::max())};
      if (what == 9) arm.sample.joints += uniform3(random, 0.5);  // the encoders leap
      if (what == 10) {
        const Duration stall = seconds(random.uniform(0.0, 0.1));
        bench.now += stall;
        if (stall > device::kLongestHold - bench.period) arm.let_go();
      }
      if (what == 11) bench.now += Duration(-bench.period.count() - 1);  // time runs back
    }
    const Vector3 before = arm.force;
    if (random.chance(wild ? 0.5 : 0.999)) {
      bench.live();
    } else {
      bench.tick();
    }
    ASSERT_TRUE(arm.force.allFinite()) << "tick " << i;
    ASSERT_LE(arm.force.norm(), peak) << "tick " << i;
    ASSERT_LE((arm.force - before).norm(), step) << "tick " << i;
    if (wild && !arm.sample.gimbal.allFinite()) arm.sample.gimbal.setZero();
    if (!bench.message.continuous.allFinite()) bench.message.continuous.setZero();
    largest = std::max(largest, arm.force.norm());
    running += bench.loop.state() == ForceState::running;
    degraded += bench.loop.state() == ForceState::degraded;
    safe += bench.loop.state() == ForceState::safe;
    if (bench.loop.state() == ForceState::safe && random.chance(0.05)) bench.loop.rearm();
  }
  // The test would show nothing if forces were hardly ever on.
  EXPECT_GT(largest, 8.4);
  EXPECT_GT(running, kTicks / 10);
  EXPECT_GT(degraded, kTicks / 100);
  EXPECT_GT(safe, kTicks / 100);
  EXPECT_GT(bench.loop.statistics().impacts, static_cast<std::uint64_t>(kTicks / 1000));
  RecordProperty("ticks", kTicks);
}

}  // namespace
}  // namespace palpate::haptics
