// A moving hand whose arm has no reading for a few milliseconds: states asked for afterwards show the tip where it was.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/server/physics/physics_server.h"

namespace palpate::server::physics {
namespace {

// Shows the tip as its only body.
class TipShown : public scene::Application {
 public:
  void step(Instant<PhysicsClock>, Duration, const scene::TipState& tip, scene::SceneState& state) override {
    state.body_count = 1;
    state.bodies[0].set_p(tip.X_world_tip.translation);
    state.bodies[0].set_q(tip.X_world_tip.rotation);
    state.bodies[0].set_v(tip.velocity);
    state.bodies[0].set_w(tip.angular_velocity);
  }
  const scene::ImpactEvent& impact() const override { return none_; }

 private:
  void begin() override {}
  void reset() override {}
  scene::ImpactEvent none_;
};

class GapInReadings : public ::testing::Test {
 protected:
  GapInReadings() {
    rig_.arm = haptics::bench_calibration();
    server_.emplace(rig_, scene::SceneDescription{}, std::make_unique<TipShown>(), arm_,
                    haptics::without_ramp());
  }
  // The hand swings at about a metre a second.
  Vector3 joints(Instant<PhysicsClock> t) const {
    const double s = std::sin(9.0 * (t - begun_).count() * 1e-9);
    return {0.1 + 0.6 * s, 0.5 + 0.3 * s, 0.3};
  }
  Vector3 truth(Instant<PhysicsClock> t) const {
    return (rig_.arm->X_world_base * device::arm_tip(rig_.arm->model, rig_.arm->correction.apply(joints(t))))
        .m;
  }
  void live(int ms, bool reads = true) {
    for (int i = 0; i < ms; ++i) {
      now_ += kMs;
      if (reads)
        arm_.sample.joints = joints(now_);
      else
        arm_.sample.joints.setConstant(std::numeric_limits<double>::quiet_NaN());
      server_->haptic_tick(now_);
      server_->physics_tick(now_);
    }
  }
  double error_at(Instant<PhysicsClock> t) const {
    const auto answer = server_->state_at(t);
    EXPECT_TRUE(answer.usable());
    return (answer.state.bodies[0].p() - truth(t)).norm();
  }

  static constexpr Duration kMs = std::chrono::milliseconds(1);
  const Instant<PhysicsClock> begun_ = Instant<PhysicsClock>::from_seconds(1.0);
  Instant<PhysicsClock> now_ = begun_;
  rig::Rig rig_;
  haptics::FakeArm arm_;
  std::optional<PhysicsServer> server_;
};

TEST_F(GapInReadings, IsBridgedOnceItIsOver) {
  live(60);
  const auto gap = now_;
  live(11, false);
  live(20);
  double moved = (truth(now_) - truth(gap)).norm(), worst = 0.0;
  EXPECT_GT(moved, 0.02);
  for (auto t = gap - 5 * kMs; t <= gap + 20 * kMs; t += Duration(250'000))
    worst = std::max(worst, error_at(t));
  RecordProperty("worst_um", static_cast<int>(1e6 * worst));
  EXPECT_LT(worst, 0.0005);
}

TEST_F(GapInReadings, IsExtrapolatedIntoWhileItLasts) {
  live(60);
  live(8, false);
  const auto answer = server_->state_at(now_);
  EXPECT_EQ(answer.kind, AnswerKind::extrapolated);
  EXPECT_LT(error_at(now_), 0.002);
}

TEST_F(GapInReadings, ThatLastsShowsTheTipWhereItWasLast) {
  live(60);
  const Vector3 last = truth(now_);
  live(200, false);
  const auto answer = server_->state_at(now_);
  EXPECT_EQ(answer.kind, AnswerKind::exact);
  EXPECT_LT((answer.state.bodies[0].p() - last).norm(), 0.006);  // carried on for 3 ms
}

}  // namespace
}  // namespace palpate::server::physics
