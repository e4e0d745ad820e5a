#include "palpate/calibration/forces/force_session.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

namespace palpate::calibration::forces {
namespace {

// An arm with a hand on it (a spring with mass, damper and friction), on a clock of its own: sleeping moves both. Motors may
// be wired wrongly. With a weight the hand is a support from below.
class HeldArm : public device::ArmDevice, public Clock<PhysicsClock> {
 public:
  HeldArm() { place_at({0.0, 0.2, 0.1}); }

  void place_at(const Vector3& theta) { tip_ = hold = device::phantom_tip(theta).m; }
  Vector3 theta() const {
    Vector3 angles = Vector3::Zero();
    device::phantom_inverse({tip_}, {}, angles);
    return angles;
  }

  device::ArmSample read() override {
    if (throws) throw std::runtime_error("cable");
    device::ArmSample sample;
    if (!silent) stamp_ = now_;
    sample.stamp = {stamp_.since_epoch};
    sample.joints = broken ? Vector3::Constant(std::numeric_limits<double>::quiet_NaN()) : theta();
    sample.connected = !gone;
    return sample;
  }
  void command(const Vector3& force) override {
    largest = std::max(largest, force.norm());
    steepest = std::max(steepest, (force - force_).norm());
    force_ = force;
  }
  void let_go() noexcept override {
    ++times_let_go;
    force_.setZero();
  }

  Instant<PhysicsClock> now() const override { return now_; }
  void sleep_until(Instant<PhysicsClock> until) override {
    if (each_tick) each_tick();
    while (now_ < until) {
      constexpr Duration kStep = std::chrono::microseconds(250);
      now_ += kStep;
      step(to_seconds(kStep));
    }
    if (late > Duration(0)) now_ += std::exchange(late, Duration(0));
  }

  Vector3 felt() const {
    const Matrix3 Jt = device::phantom_jacobian(theta()).transpose();
    return Jt.inverse() * motors * Jt * axes.cwiseProduct(force_);
  }
  const Vector3& commanded() const { return force_; }
  const Vector3& tip() const { return tip_; }

  Vector3 hold, axes = Vector3::Ones();
  Matrix3 motors = Matrix3::Identity();
  double stiffness = 250.0, friction = 0.02, weight = 0.0;  // N/m, N, N
  bool held = true, silent = false, gone = false, broken = false, throws = false;
  Duration late{0};
  std::function<void()> each_tick;
  double largest = 0.0, steepest = 0.0;
  int times_let_go = 0;

 private:
  void step(double h) {
    const double mass = 0.12 + weight / 9.81;
    Vector3 force = felt() - velocity_ * (friction / (velocity_.norm() + 0.001)) - 0.2 * velocity_;
    if (weight > 0.0) {
      force.y() -= weight;
      if (tip_.y() < hold.y())
        force += Vector3(0.0, 3000.0 * (hold.y() - tip_.y()) - 20.0 * velocity_.y(), 0.0);
      force += Vector3(300.0 * (hold.x() - tip_.x()) - 8.0 * velocity_.x(), 0.0,
                       300.0 * (hold.z() - tip_.z()) - 8.0 * velocity_.z());
    } else if (held) {
      force += stiffness * (hold - tip_) - 8.0 * velocity_;
    }
    velocity_ += h / mass * force;
    tip_ += h * velocity_;
  }

  Vector3 tip_, velocity_ = Vector3::Zero(), force_ = Vector3::Zero();
  Instant<PhysicsClock> now_, stamp_;
};

class TestPerson : public ForcePerson {
 public:
  explicit TestPerson(HeldArm& arm) : arm_(arm) {}
  bool key_held(std::uint32_t) override { return holds; }
  void say(const std::string& line) override { lines.push_back(line); }
  void pose_wanted(int pose, const Vector3&) override {
    const Vector3 angles[] = {
        {0.0, 0.2, 0.1}, {-0.5, 0.5, 0.1}, {0.5, 0.4, -0.2}, {-0.5, 0.0, -0.3}, {0.5, 0.1, 0.3}};
    if (pose < 5) arm_.hold = device::phantom_tip(angles[pose]).m;
    if (pose == 5 && weight_n > 0.0) arm_.weight = weight_n, arm_.hold = arm_.tip();
  }
  bool heard(const std::string& words) const {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const auto& line) { return line.find(words) != std::string::npos; });
  }
  bool holds = true;
  double weight_n = 0.0;
  std::vector<std::string> lines;

 private:
  HeldArm& arm_;
};

rig::Rig true_rig() {
  rig::Rig rig;
  rig.arm.emplace();
  return rig;
}

struct Session {
  HeldArm arm;
  TestPerson person{arm};
  ForceSessionSettings settings;
  Expected<ForceObservations> run() { return observe_forces(arm, true_rig(), arm, person, settings); }
  ForceVerdict verdict() {
    const auto seen = run();
    EXPECT_TRUE(seen) << (seen ? "" : seen.error().message);
    if (!seen) return ForceVerdict::unexplained;
    const auto check = check_forces(seen->poses);
    EXPECT_TRUE(check);
    return check ? check->verdict : ForceVerdict::unexplained;
  }
};

TEST(ForceSession, AHealthyArmAgreesAndIsNeverCommandedMoreThanHalfANewton) {
  Session session;
  EXPECT_EQ(session.verdict(), ForceVerdict::agreed);
  EXPECT_GT(session.arm.largest, 0.49);
  EXPECT_LE(session.arm.largest, 0.5 + 1e-12);
  EXPECT_LE(session.arm.steepest, 0.05 + 1e-12);  // 50 N/s
  EXPECT_EQ(session.arm.commanded().norm(), 0.0);
}

TEST(ForceSession, EachFaultOfTheMotorsIsRefusedByItsName) {
  {
    Session session;
    session.arm.axes = {1.0, 1.0, -1.0};
    EXPECT_EQ(session.verdict(), ForceVerdict::axis_mirrored);
  }
  {
    Session session;
    session.arm.motors.col(1).swap(session.arm.motors.col(2));
    EXPECT_EQ(session.verdict(), ForceVerdict::joints_exchanged);
  }
  {
    Session session;
    session.arm.motors(0, 0) = 2.0;
    EXPECT_EQ(session.verdict(), ForceVerdict::ratio_off);
  }
  {
    Session session;
    session.arm.motors(2, 2) = 0.0;
    EXPECT_EQ(session.verdict(), ForceVerdict::joint_without_power);
  }
  {
    Session session;
    session.arm.stiffness = 2e4;  // leans on something
    EXPECT_EQ(session.verdict(), ForceVerdict::too_little_motion);
  }
}

TEST(ForceSession, AKeyReleasedInARampTakesTheForceInTheSameTickAndTheRampIsPlayedAgain) {
  Session session;
  int ticks_without = 0;
  bool done = false;
  session.arm.each_tick = [&] {
    if (!session.person.holds) {
      if (++ticks_without > 1) {
        EXPECT_EQ(session.arm.commanded().norm(), 0.0);
      }
      session.person.holds = ticks_without > 200;
      done = true;
    } else if (!done && session.arm.commanded().norm() > 0.4) {
      session.person.holds = false;
    }
  };
  EXPECT_EQ(session.verdict(), ForceVerdict::agreed);
  EXPECT_TRUE(session.person.heard("broken off (key released)"));
}

TEST(ForceSession, WhereNobodyHoldsTheStylusItIsBrokenOffAndRefused) {
  Session session;
  session.settings.poses = 1;
  session.arm.held = false;
  session.arm.friction = 0.0;
  const auto seen = session.run();
  ASSERT_FALSE(seen);
  EXPECT_EQ(seen.error().exit_code(), 1);
  EXPECT_NE(seen.error().message.find("hold the stylus a little more firmly"), std::string::npos)
      << seen.error().message;
  EXPECT_GE(session.arm.times_let_go, 6);
}

TEST(ForceSession, RefusesToGoOnWithoutKeyArmOrPatience) {
  {
    Session session;
    session.person.holds = false;
    session.settings.patience_s = 3.0;
    const auto seen = session.run();
    ASSERT_FALSE(seen);
    EXPECT_NE(seen.error().message.find("key was not held"), std::string::npos);
    EXPECT_EQ(session.arm.largest, 0.0);
  }
  {
    Session session;
    session.arm.each_tick = [&] {
      session.arm.gone = session.arm.gone || session.arm.commanded().norm() > 0.3;
    };
    const auto seen = session.run();
    ASSERT_FALSE(seen);
    EXPECT_NE(seen.error().message.find("arm is gone"), std::string::npos);
    EXPECT_EQ(session.arm.commanded().norm(), 0.0);
  }
  Session session;
  session.settings.poses = 6;
  const auto seen = session.run();
  ASSERT_FALSE(seen);
  EXPECT_EQ(seen.error().exit_code(), 2);
}

// A push of 0.4 N under way, then something happens.
struct Push {
  HeldArm arm;
  ForcePusher pusher{arm, true_rig()};
  bool key = true;
  Instant<PhysicsClock> next;
  BreakOff tick(double newton = 0.4) {
    next += std::chrono::milliseconds(1);
    arm.sleep_until(next);
    return pusher.tick(arm.now(), newton * Vector3::UnitX(), key);
  }
  Push() {
    tick(0.0);
    pusher.begin();
    for (int i = 0; i < 300; ++i) EXPECT_EQ(tick(), BreakOff::none) << i;
    EXPECT_NEAR(arm.commanded().norm(), 0.4, 1e-9);
  }
  // The reason, and how many ms the force was still on after the tick in which it showed.
  BreakOff broken_off(int within_ms) {
    for (int ms = 1; ms <= within_ms; ++ms)
      if (const BreakOff reason = tick(); reason != BreakOff::none) {
        EXPECT_EQ(arm.commanded().norm(), 0.0);
        EXPECT_GE(arm.times_let_go, 1);
        return reason;
      }
    return BreakOff::none;
  }
};

TEST(ForcePusher, BreaksOffWithinATickAtEachReason) {
  {
    Push push;
    push.key = false;
    EXPECT_EQ(push.broken_off(1), BreakOff::key_released);
  }
  {
    Push push;  // drawn away slowly: 10 mm in 0.2 s
    BreakOff reason = BreakOff::none;
    for (int ms = 0; ms < 400 && reason == BreakOff::none; ++ms) {
      push.arm.hold += Vector3(0.0, 0.00006, 0.0);
      reason = push.tick();
    }
    EXPECT_EQ(reason, BreakOff::too_far);
    EXPECT_NEAR(push.pusher.way().norm(), 0.010, 0.0005);
    EXPECT_EQ(push.arm.commanded().norm(), 0.0);
  }
  {
    Push push;
    push.arm.hold += Vector3(0.0, 0.05, 0.0);  // torn away
    EXPECT_EQ(push.broken_off(40), BreakOff::too_fast);
    EXPECT_LT(push.pusher.way().norm(), 0.010);
  }
  {
    Push push;
    push.arm.silent = true;
    EXPECT_EQ(push.broken_off(6), BreakOff::arm_silent);
  }
  {
    Push push;
    push.arm.gone = true;
    EXPECT_EQ(push.broken_off(1), BreakOff::arm_lost);
  }
  {
    Push push;
    push.arm.throws = true;
    EXPECT_EQ(push.broken_off(1), BreakOff::arm_lost);
  }
  {
    Push push;
    push.arm.broken = true;
    EXPECT_EQ(push.broken_off(1), BreakOff::bad_reading);
  }
  {
    Push push;
    push.arm.late = std::chrono::milliseconds(8);
    EXPECT_EQ(push.broken_off(1), BreakOff::late_tick);
  }
}

TEST(ForcePusher, LetsGoAtItsEndAndNeedsACalibratedArm) {
  HeldArm arm;
  {
    ForcePusher pusher(arm, true_rig());
    arm.sleep_until(Instant<PhysicsClock>::from_seconds(0.001));
    pusher.tick(arm.now(), Vector3::UnitX(), true);
    EXPECT_GT(arm.commanded().norm(), 0.0);
  }
  EXPECT_EQ(arm.commanded().norm(), 0.0);
  EXPECT_EQ(arm.times_let_go, 1);
  EXPECT_THROW(ForcePusher(arm, rig::Rig{}), std::invalid_argument);
}

TEST(ForceSession, AKnownWeightTellsTheSize) {
  for (const double gain : {1.0, 0.8}) {
    Session session;
    session.settings.poses = 1;
    session.settings.weight_kg = 0.05;
    session.person.weight_n = 0.05 * 9.81;
    session.arm.motors *= gain;
    // One pose, so that pose 5 of the person is the weight's.
    struct Weigher : TestPerson {
      using TestPerson::TestPerson;
      void pose_wanted(int pose, const Vector3& tip) override {
        TestPerson::pose_wanted(pose == 1 ? 5 : pose, tip);
      }
    } weigher(session.arm);
    weigher.weight_n = session.person.weight_n;
    const auto seen = observe_forces(session.arm, true_rig(), session.arm, weigher, session.settings);
    ASSERT_TRUE(seen) << seen.error().message;
    const auto found = gain_of_weight(weigher.weight_n, seen->rising, seen->sinking);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NEAR(found->gain, gain, 0.05);
    EXPECT_LE(session.arm.largest, 1.0 + 1e-12);
  }
}

}  // namespace
}  // namespace palpate::calibration::forces
