#include "palpate/desktop/hand_leader.h"

#include <gtest/gtest.h>

#include <vector>

namespace palpate::desktop {
namespace {

device::CameraModel leaders_camera() { return {640, 480, 560, 560, 320, 240, {}}; }

MouseHandSettings leaders_settings() {
  MouseHandSettings settings;
  settings.home = Vector3(0.0, 0.0, 0.0);
  return settings;
}

// Looks along -z from 0.8 m in front of the hand's home.
const Pose<World, CameraOptical> kLeadersPose{Quaternion(0.0, 1.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.8)};

class RecordingHand : public device::HandDevice {
 public:
  void move_to(const device::HandTarget& target) override {
    const std::lock_guard lock(mutex_);
    at_ns_.push_back(MonotonicClock<GraphicsClock>::monotonic_ns());
    last_ = target;
  }
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return at_ns_.size();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::int64_t> at_ns_;
  device::HandTarget last_;
};

// A stroke that always wants the hand in one place, and remembers what it was asked.
class StubbornAssist : public scene::InputAssist {
 public:
  explicit StubbornAssist(std::vector<scene::Led>& asked) : asked_(asked) {}
  void show(const scene::SceneState&) override {}
  std::optional<device::HandTarget> act(Instant<PhysicsClock>, const scene::Led& led) override {
    asked_.push_back(led);
    device::HandTarget target;
    target.tip.m = Vector3(0.0, 0.3, 0.0);
    return target;
  }

 private:
  std::vector<scene::Led>& asked_;
};

TEST(HandLeader, SaysWithEachTargetWhetherTheHeadIsHeldStill) {
  std::vector<scene::Led> asked;
  HandLeader leader(MouseHand(leaders_camera(), leaders_settings()), std::make_unique<StubbornAssist>(asked));
  leader.look_through(leaders_camera(), kLeadersPose);
  leader.synchronised({});
  const auto now = Instant<GraphicsClock>::from_seconds(1.0);
  EXPECT_FALSE(leader.step(now).head_still);
  EXPECT_TRUE(leader.turn_head_still());
  EXPECT_TRUE(leader.step(now).head_still) << "in a stroke, too";
  EXPECT_EQ(asked.size(), 2u);
  EXPECT_FALSE(leader.turn_head_still());
  EXPECT_FALSE(leader.step(now).head_still);
}

TEST(HandLeader, GoesOnWhileTheOneWhoDrawsStandsStill) {
  RecordingHand device;
  const MonotonicClock<GraphicsClock> clock;
  HandLeader leader(MouseHand(leaders_camera(), leaders_settings()), nullptr);
  leader.start(device, clock);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(device.count(), 0u) << "nobody leads yet";
  leader.take_over(std::nullopt, clock.now());
  // As long as a machine may take that has other things to do.
  for (int i = 0; i < 1000 && device.count() < 20; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_GE(device.count(), 20u) << "this thread asked for nothing";
  leader.let_go(clock.now());
  const auto let_go = device.count();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(device.count(), let_go) << "another may move it now";
}

TEST(HandLeader, TheHandGoesUnderThePointer) {
  HandLeader leader(MouseHand(leaders_camera(), leaders_settings()), nullptr);
  leader.look_through(leaders_camera(), kLeadersPose);
  leader.point({320.0 + 56.0, 240.0});
  device::HandTarget target;
  for (int ms = 0; ms < 2000; ++ms) target = leader.step(Instant<GraphicsClock>::from_seconds(1e-3 * ms));
  const Vector3 bat = target.tip.m + target.R_world_tip * leaders_settings().offset;
  const Vector3 seen = (kLeadersPose.inverse() * Point<World>{bat}).m;
  EXPECT_NEAR(560.0 * seen.x() / seen.z(), 56.0, 1.0);
}

TEST(HandLeader, AStrokeComesFirstWhereTimeAndEyeAreKnownUntilHelpIsTurnedOff) {
  std::vector<scene::Led> asked;
  HandLeader leader(MouseHand(leaders_camera(), leaders_settings()), std::make_unique<StubbornAssist>(asked));
  const auto at = [](int ms) { return Instant<GraphicsClock>::from_seconds(1e-3 * ms); };
  leader.step(at(1));
  EXPECT_TRUE(asked.empty()) << "when is a stroke due where the physics host's time is not known?";
  leader.look_through(leaders_camera(), kLeadersPose);
  leader.synchronised({});
  leader.hold_buttons(false, true);
  EXPECT_EQ(leader.step(at(2)).tip.m, Vector3(0.0, 0.3, 0.0));
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_EQ(asked[0].eye, kLeadersPose.translation);
  EXPECT_EQ(asked[0].side, 1.0);
  EXPECT_EQ(leader.turn_help(), false);
  leader.step(at(3));
  EXPECT_EQ(asked.size(), 1u);
  EXPECT_EQ(leader.turn_help(), true);
  leader.step(at(4));
  EXPECT_EQ(asked.size(), 2u);
  HandLeader unaided(MouseHand(leaders_camera(), leaders_settings()), nullptr);
  EXPECT_EQ(unaided.turn_help(), std::nullopt) << "there is nothing to turn";
}

}  // namespace
}  // namespace palpate::desktop
