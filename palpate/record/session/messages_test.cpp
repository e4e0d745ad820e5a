// Each message comes back as it was, bit by bit; what is damaged or makes no sense is refused.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <memory>

#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/frame_messages.h"
#include "palpate/record/session/tick_messages.h"

namespace palpate::record::session {
namespace {

RecordedHapticTick some_tick() {
  RecordedHapticTick recorded;
  auto& tick = recorded.tick;
  tick.number = 7;
  tick.begun = {Duration(-5)};
  tick.sample.stamp = {Duration(123456789012345)};
  tick.sample.joints = {0.1, 1.0 / 3.0, -2e-300};
  tick.sample.gimbal = {0.3, std::numeric_limits<double>::quiet_NaN(), 0.0};
  tick.sample.connected = false;
  tick.sample.withheld = {1.0, 2.0, 3.0};
  tick.sample.waited = Duration(250);
  tick.sample.held = Vector3(0.1, 0.2, 0.3);
  tick.sample.buttons = 0x80000001u;
  tick.tip = {0.1, 0.2, 0.7};
  tick.speed = 0.25;
  tick.continuous = {0.0, 1.0 / 7.0, 0.0};
  tick.impact = {3.0, 0.0, -0.0};
  tick.commanded = {0.5, -0.5, 1e-17};
  tick.state = haptics::ForceState::degraded;
  tick.fault = haptics::ForceFault::arm_slow;
  tick.culprit = haptics::Guest::arm;
  recorded.inputs = {true, {0, 1, ~0ull}};
  return recorded;
}

bool same(const Vector3& a, const Vector3& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0;
}

TEST(RecordedTick, ComesBackBitByBit) {
  const auto sent = some_tick();
  auto back = decode_sample(encode_sample(sent));
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_TRUE(decode_force(encode_force(sent.tick), back->tick));
  EXPECT_EQ(back->tick.number, 7u);
  EXPECT_EQ(back->tick.begun, sent.tick.begun);
  EXPECT_EQ(back->tick.sample.stamp, sent.tick.sample.stamp);
  EXPECT_EQ(back->tick.sample.joints, sent.tick.sample.joints);
  EXPECT_TRUE(same(back->tick.sample.gimbal, sent.tick.sample.gimbal)) << "what is no number stays none";
  EXPECT_FALSE(back->tick.sample.connected);
  EXPECT_TRUE(same(*back->tick.sample.held, *sent.tick.sample.held));
  EXPECT_TRUE(same(back->tick.sample.withheld, sent.tick.sample.withheld));
  EXPECT_EQ(back->tick.sample.buttons, sent.tick.sample.buttons);
  EXPECT_EQ(back->tick.sample.waited, sent.tick.sample.waited);
  EXPECT_TRUE(same(back->tick.impact, sent.tick.impact)) << "the sign of a zero, too";
  EXPECT_TRUE(same(back->tick.commanded, sent.tick.commanded));
  EXPECT_EQ(back->tick.state, sent.tick.state);
  EXPECT_EQ(back->tick.fault, sent.tick.fault);
  EXPECT_EQ(back->tick.culprit, sent.tick.culprit);
  EXPECT_EQ(back->inputs.values, sent.inputs.values);
  EXPECT_TRUE(back->inputs.exact);
}

TEST(RecordedTick, WithoutAForceThatItHoldsThereIsNone) {
  auto sent = some_tick();
  sent.tick.sample.held.reset();
  EXPECT_FALSE(decode_sample(encode_sample(sent))->tick.sample.held);
}

TEST(RecordedTick, TheRingGivesWhatItWasGiven) {
  const auto ring = std::make_unique<HapticTickRing>();
  auto sent = some_tick();
  InputTrace trace;
  trace.write();
  {
    const InputTrace::Scope scope(&trace);
    for (const auto value : sent.inputs.values) InputTrace::pass(value);
  }
  ring->push(sent.tick, trace);
  const auto back = ring->read(0);
  ASSERT_TRUE(back);
  EXPECT_EQ(encode_sample(*back), encode_sample(sent));
  EXPECT_EQ(encode_force(back->tick), encode_force(sent.tick));
  EXPECT_FALSE(ring->read(1));
}

TEST(RecordedStep, ComesBackAsItWas) {
  const auto ring = std::make_unique<StepRing>();
  InputTrace trace;
  trace.write();
  {
    const InputTrace::Scope scope(&trace);
    InputTrace::pass(9);
  }
  ring->control(scene::Control::reset);
  ring->control(scene::Control::pause);
  scene::SceneState state;
  state.tick = 4;
  state.body_count = 1;
  state.bodies[0].set_p({1.0, 2.0, 3.0});
  ring->push({Duration(77)}, &state, trace);
  ring->push({Duration(78)}, nullptr, trace);
  const auto step = ring->read(0);
  ASSERT_TRUE(step && step->state);
  EXPECT_EQ(step->state->bodies[0].p(), Vector3(1.0, 2.0, 3.0));
  const auto back = decode_step(encode_step(*step));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->number, 1u);
  EXPECT_EQ(back->now.ns(), 77);
  EXPECT_EQ(back->controls, (std::vector{scene::Control::reset, scene::Control::pause}));
  EXPECT_EQ(back->inputs.values, std::vector<std::uint64_t>{9});
  const auto second = ring->read(1);
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->state);
  EXPECT_TRUE(second->controls.empty());
}

TEST(RecordedStep, MoreWishesThanThereIsRoomForAreCounted) {
  const auto ring = std::make_unique<StepRing>();
  for (std::size_t i = 0; i < StepRing::kMostControls + 3; ++i) ring->control(scene::Control::pause);
  InputTrace trace;
  trace.write();
  ring->push({}, nullptr, trace);
  EXPECT_EQ(ring->read(0)->controls.size(), StepRing::kMostControls);
  EXPECT_EQ(ring->read(0)->controls_left_out, 3u);
}

TEST(RecordedTrackerSample, ComesBackBitByBit) {
  RecordedTrackerSample sent;
  sent.sample.stamp = {Duration(5)};
  sent.sample.marker = device::MarkerId::pointer;
  sent.sample.seen = true;
  sent.sample.rotation = Quaternion(0.5, -0.5, 0.5, 0.5);
  sent.sample.translation = {0.1, 0.2, 1.0 / 3.0};
  sent.sample.covariance = Matrix6::Identity() * 1e-8;
  sent.sample.covariance(0, 5) = sent.sample.covariance(5, 0) = 1e-9;
  sent.sample.systematic = Matrix3::Identity() * 1e-10;
  sent.sample.leds = 4;
  sent.arrived_ns = 99;
  const auto back = decode_tracker_sample(encode(sent));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->sample.marker, sent.sample.marker);
  EXPECT_EQ(back->sample.rotation.coeffs(), sent.sample.rotation.coeffs());
  EXPECT_EQ(back->sample.translation, sent.sample.translation);
  EXPECT_EQ(back->sample.covariance, sent.sample.covariance);
  EXPECT_EQ(back->sample.systematic, sent.sample.systematic);
  EXPECT_EQ(back->sample.leds, 4);
  EXPECT_EQ(back->arrived_ns, 99);
  sent.sample.seen = false;
  EXPECT_FALSE(decode_tracker_sample(encode(sent))->sample.seen);
}

// As a file of single precision has it, or another program's.
TEST(RecordedTrackerSample, ATurnThatWasWrittenRoughlyIsMadeOne) {
  RecordedTrackerSample sent;
  sent.sample.seen = true;
  for (const double scale : {1.0 + 9e-4, 1.0 - 9e-4, 1.0 + 2e-7}) {
    sent.sample.rotation.coeffs() = scale * Quaternion(0.5, -0.5, 0.5, 0.5).coeffs();
    const auto back = decode_tracker_sample(encode(sent));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_NEAR(back->sample.rotation.norm(), 1.0, 1e-15);
  }
}

TEST(RecordedTrackerSample, WhatMakesNoSenseIsRefused) {
  RecordedTrackerSample bad;
  bad.sample.seen = true;
  bad.sample.rotation = Quaternion(2.0, 0.0, 0.0, 0.0);
  EXPECT_FALSE(decode_tracker_sample(encode(bad)));
  bad.sample.rotation = Quaternion::Identity();
  bad.sample.translation.x() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(decode_tracker_sample(encode(bad)));
  bad.sample.translation.x() = 0.0;
  bad.sample.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(decode_tracker_sample(encode(bad)));
}

TEST(RecordedFrame, ComesBackAsItWas) {
  RecordedFrame sent;
  sent.number = 3;
  sent.image_time = {Duration(11)};
  sent.pose_source = RecordedFrame::PoseSource::refined;
  sent.X_world_camera.translation = {0.1, 0.2, 0.3};
  sent.pose_covariance = Matrix6::Identity() * 1e-6;
  sent.landmarks_used = 12;
  sent.expected_world_px = 0.25;
  const auto back = decode_frame(encode(sent));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->pose_source, sent.pose_source);
  EXPECT_EQ(back->X_world_camera.translation, sent.X_world_camera.translation);
  EXPECT_EQ(back->pose_covariance, sent.pose_covariance);
  EXPECT_EQ(back->landmarks_used, 12);
  EXPECT_EQ(back->expected_world_px, 0.25);
}

// Cut off or changed anywhere a message is refused, or another one that makes sense: never anything worse.
TEST(RecordedMessages, DamagedOnesDoNoHarm) {
  const std::string whole[] = {encode_sample(some_tick()), encode_force(some_tick().tick)};
  for (const auto& bytes : whole)
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
      haptics::HapticTick tick;
      for (const auto& tried : {bytes.substr(0, i), damaged}) {
        const auto read = decode_sample(tried);
        EXPECT_TRUE(!read || read->tick.sample.joints.size() <= device::kMostJoints);
        static_cast<void>(decode_force(tried, tick));
        static_cast<void>(decode_step(tried));
        static_cast<void>(decode_tracker_sample(tried));
        static_cast<void>(decode_camera_stamp(tried));
        static_cast<void>(decode_frame(tried));
      }
    }
}

}  // namespace
}  // namespace palpate::record::session
