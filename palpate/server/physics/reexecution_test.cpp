// Sessions of both loops in threads of their own, on the machine's clock, recorded and executed again. The arm moves with the
// time at which it is read and the application passes values both ways between its loops, so hardly two runs are alike: what
// comes out again is what was recorded, or the test fails.
#include "palpate/server/physics/reexecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <thread>

#include "palpate/haptics/haptic_bench_test.h"
#include "palpate/record/recording_copy.h"
#include "palpate/record/session/physics_recorder.h"
#include "palpate/scene/generic_view.h"
#include "palpate/server/physics/physics_side.h"
#include "palpate/server/physics/recorded_setup.h"
#include "palpate/server/physics/rig_for_tests.h"
#include "tests/scratch_folder.h"

namespace palpate::server::physics {
namespace {

// A wall that moves and gives way to what the law has found: each loop depends on the other's newest value.
class YieldingWall : public scene::Application, public scene::ContactLaw {
 public:
  void step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
            scene::SceneState& state) override {
    double felt = 0.0;
    if (felt_.read(felt)) pushed_ += 1e-3 * felt * to_seconds(dt);
    pushed_ *= 1.0 - to_seconds(dt);
    const double place = 0.01 * std::sin(11.0 * to_seconds(now.since_epoch)) - pushed_;
    wall_.write(tip.X_world_tip.translation.y() + place);
    state.body_count = 1;
    state.bodies[0].set_p({0.0, place, pushed_});
    state.counters[0] = resets_;
    if (now - impact_.start < std::chrono::milliseconds(100)) return;
    impact_.number += 1;
    impact_.start = now;
    impact_.duration = std::chrono::milliseconds(4);
    impact_.direction = Vector3(0.0, 1.0, 0.0);
    impact_.approach_speed = 1.0 + pushed_;
    impact_.mass = 0.0027;
  }
  const scene::ImpactEvent& impact() const override { return impact_; }
  scene::ContactLaw* contact_law() override { return this; }

  Vector3 force(const scene::TipState& tip, double) noexcept override {
    wall_.read(seen_);
    const double depth = seen_ - tip.X_world_tip.translation.y() + 0.01;
    const double force = std::clamp(80.0 * depth, 0.0, 3.0);
    felt_.write(force);
    return {0.0, force, 0.0};
  }
  double force_bound() const override { return 4.0; }
  Duration cost_bound() const override { return std::chrono::microseconds(200); }

 private:
  void begin() override {}
  void reset() override { ++resets_; }
  TripleBuffer<double> wall_, felt_;
  double pushed_ = 0.0, seen_ = 0.0;
  int resets_ = 0;
  scene::ImpactEvent impact_;
};

// Where it is depends on when it is read.
class RestlessArm : public device::OpenedArm, public device::ArmDevice {
 public:
  device::ArmDevice& device() override { return *this; }
  device::ArmFacts facts() const override {
    device::ArmFacts facts;
    facts.simulated = true;
    facts.identity = "restless";
    facts.peak_n = 6.5;
    return facts;
  }
  device::ArmSample read() override {
    device::ArmSample sample;
    sample.stamp = clock_.now();
    const double t = to_seconds(sample.stamp.since_epoch);
    sample.joints = {0.1 + 0.05 * std::sin(7.0 * t), 0.5 + 0.04 * std::sin(5.0 * t), 0.3};
    sample.gimbal = {0.2, 0.1 * std::sin(3.0 * t), 0.0};
    sample.waited =
        std::chrono::microseconds(static_cast<std::int64_t>(100.0 * std::abs(std::sin(900.0 * t))));
    return sample;
  }
  void command(const Vector3&) override {}
  void let_go() noexcept override {}

 private:
  MonotonicClock<ArmClock> clock_;
};

// `kept`: learns whether the run that is made keeps files.
scene::ApplicationRegistry applications(bool* kept = nullptr) {
  scene::ApplicationSpec wall;
  wall.name = "yielding-wall";
  wall.summary = "A wall that gives way";
  wall.make_physics = [kept](const auto&, const scene::RunSettings& run) {
    if (kept != nullptr) *kept = run.keeps_files;
    return std::make_unique<YieldingWall>();
  };
  wall.make_view = [](const auto&) { return std::make_unique<scene::GenericView>("yielding-wall"); };
  return {wall};
}

PhysicsSetup restless_setup() {
  PhysicsSetup setup;
  setup.rig = rig_of_table_and_wall();
  setup.applications = applications();
  setup.scene.application = "yielding-wall";
  device::ArmOpener opener;
  opener.form = "restless";
  opener.open = [](const device::ArmRequest&) -> Expected<std::unique_ptr<device::OpenedArm>> {
    return std::make_unique<RestlessArm>();
  };
  setup.drivers.add(device::Driver{.scheme = "restless", .summary = "an arm that moves", .arm = opener});
  setup.arm.uri = "restless";
  setup.extra_force_delay = std::chrono::milliseconds(2);
  return setup;
}

// Half a second of it, with wishes on the way.
void record_session(const std::filesystem::path& file) {
  const PhysicsSetup setup = restless_setup();
  MonotonicClock<PhysicsClock> clock;
  const MachineThreadClock guests;
  auto side = PhysicsSide::open(setup, &guests);
  ASSERT_TRUE(side) << side.error().message;
  auto recording = record::session::SessionRecording::begin(file, {.recorder = "test", .on_error = {}});
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_TRUE((*recording)->describe(kSetupWords, words_of(recorded_setup(setup, (*side)->arm(), true))));
  const auto ticks = std::make_unique<record::session::PhysicsTicks>();
  (*side)->server().record_to(*ticks);
  record::session::PhysicsRecorder recorder(**recording, *ticks, (*side)->server().haptic(), setup.rig,
                                            (*side)->scene());
  recorder.start();
  {
    std::atomic<bool> done{false};
    std::jthread haptic([&] {
      while (!done) {
        (*side)->haptic_tick(clock.now());
        std::this_thread::sleep_for(std::chrono::microseconds(900));
      }
    });
    // A step in between takes long, so that the loops meet in other orders; every tenth follows a person's wish.
    for (int i = 0; i < 400; ++i) {
      if (i % 10 == 0) (*side)->server().control(i % 20 == 0 ? scene::Control::reset : scene::Control::begin);
      (*side)->physics_tick(clock.now());
      std::this_thread::sleep_for(std::chrono::microseconds(i % 7 == 0 ? 4000 : 800));
    }
    done = true;
  }
  recorder.stop();
  const Json figures = (*recording)->close();
  EXPECT_FALSE(figures.contains("error"));
  EXPECT_EQ(recorder.missed(), 0u);
  EXPECT_TRUE(figures["dropped"].empty()) << figures.dump();
}

class ReexecutionTest : public testing::Test {
 protected:
  void SetUp() override { record_session(file_); }
  static Expected<Reexecution> again(const std::filesystem::path& file) {
    return execute_again({.recording = file, .applications = applications(), .mesh = {}});
  }
  // A copy without some messages of a topic, from the `at`-th on.
  std::filesystem::path without(const std::string& topic, std::uint64_t at, std::uint64_t count = 1) const;

  ScratchFolder folder_;
  std::filesystem::path file_ = folder_.path() / "session.mcap";
};

TEST_F(ReexecutionTest, EveryForceIsEqualToTheLastBit) {
  const auto result = again(file_);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_TRUE(result->same()) << json_of(*result).dump(2);
  EXPECT_GT(result->ticks, 100u);
  EXPECT_GT(result->steps, 100u);
}

TEST_F(ReexecutionTest, LeavesWhatPeopleKeepAlone) {
  bool kept = true;
  ASSERT_TRUE(execute_again({.recording = file_, .applications = applications(&kept), .mesh = {}}));
  EXPECT_FALSE(kept);
}

// Copies a recording, all but some messages of a topic.
class Omitter : public record::ScanHandler {
 public:
  // From the `at`-th on so many.
  Omitter(record::McapWriter& out, std::string topic, std::uint64_t at, std::uint64_t count)
      : out_(out), topic_(std::move(topic)), at_(at), count_(count) {}
  Expected<void> message(const record::HeardMessage& heard) override {
    if (heard.channel.topic == topic_)
      if (const std::uint64_t number = seen_++; number >= at_ && number - at_ < count_) return {};
    record::Channel channel = heard.channel;
    channel.schema = 0;
    const auto number = out_.add_channel(channel);
    if (!number) return tl::unexpected(number.error());
    record::Message message = heard.message;
    message.channel = *number;
    return out_.write(message);
  }
  Expected<void> attachment(const record::Attachment& attachment) override { return out_.attach(attachment); }
  Expected<void> metadata(const record::Metadata& metadata) override { return out_.write(metadata); }

 private:
  record::McapWriter& out_;
  std::string topic_;
  std::uint64_t at_, count_, seen_ = 0;
};

std::filesystem::path ReexecutionTest::without(const std::string& topic, std::uint64_t at,
                                               std::uint64_t count) const {
  const auto copy = folder_.path() / "copy.mcap";
  auto file = record::RecordFile::whole(copy);
  EXPECT_TRUE(file);
  auto writer = record::McapWriter::begin(std::move(*file));
  EXPECT_TRUE(writer);
  auto source = record::open_source(file_);
  EXPECT_TRUE(source);
  Omitter omitter(*writer, topic, at, count);
  EXPECT_TRUE(record::scan(**source, {}, omitter));
  EXPECT_TRUE(writer->close());
  return copy;
}

// Of each kind of input any one that is missing is noticed, and named by its number.
TEST_F(ReexecutionTest, OneInputThatIsMissingIsNoticed) {
  for (const std::string topic : {"/arm/sample", "/physics/step", "/arm/force", "/physics/state"})
    for (const std::uint64_t at : {0u, 77u}) {
      const auto result = again(without(topic, at));
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_FALSE(result->same()) << topic << " " << at;
      EXPECT_FALSE(result->first_difference.empty()) << topic << " " << at;
    }
}

// A file that breaks off ends one loop's record before the other's: what there is has no difference.
TEST_F(ReexecutionTest, WhatBreaksOffIsEqualAsFarAsItGoes) {
  const auto whole = again(file_);
  ASSERT_TRUE(whole) << whole.error().message;
  for (const std::string topic : {"/physics/step", "/arm/force", "/physics/state"}) {
    const bool of_ticks = topic == "/arm/force";
    const std::uint64_t all = of_ticks ? whole->recorded_ticks : whole->recorded_steps;
    const auto result = again(without(topic, all - 20, 20));
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_TRUE(result->same()) << topic << json_of(*result).dump(2);
    EXPECT_GT(result->ticks_beyond + result->steps_beyond, 0u) << topic;
    EXPECT_GT(result->ticks + 80, whole->ticks) << topic;
    // Not where the one is missing long before the other ends.
    const auto half = again(without(topic, all / 2, all));
    ASSERT_TRUE(half) << half.error().message;
    EXPECT_FALSE(half->same()) << topic << json_of(*half).dump(2);
    EXPECT_FALSE(half->first_difference.empty()) << topic;
  }
}

TEST_F(ReexecutionTest, WithoutWhatItWasMadeOfItIsRefused) {
  const auto bare = folder_.path() / "bare.mcap";
  {
    auto file = record::RecordFile::whole(bare);
    ASSERT_TRUE(file);
    auto writer = record::McapWriter::begin(std::move(*file));
    ASSERT_TRUE(writer && writer->close());
  }
  const auto refusal = again(bare);
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("rig.toml is missing"), std::string::npos)
      << refusal.error().message;
  EXPECT_FALSE(again(folder_.path() / "nowhere.mcap"));
}

TEST(RecordedSetup, ComesBackFromItsWords) {
  RecordedSetup setup;
  setup.run.seed = 12345678901234567890ull;
  setup.run.pause_s = 0.1;
  setup.haptic_hz = 4000.0 / 3.0;
  setup.armed = false;
  setup.arm.peak_n = 0.1 + 0.2;
  setup.torque_limits = device::JointVector{0.1, 1.0 / 3.0};
  const auto words = words_of(setup);
  const auto back = setup_of(words);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(words_of(*back), words);
  EXPECT_EQ(back->run.seed, setup.run.seed);
  EXPECT_EQ(back->run.pause_s, setup.run.pause_s);
  EXPECT_EQ(back->haptic_hz, setup.haptic_hz);
  EXPECT_EQ(back->armed, setup.armed);
  EXPECT_EQ(back->arm.peak_n, setup.arm.peak_n);
  EXPECT_EQ((*back->torque_limits)[1], 1.0 / 3.0);
  for (const auto& [name, value] : words) {
    auto broken = words;
    broken[name] = "abc";
    if (name == "arm_identity") continue;
    const auto refusal = setup_of(broken);
    ASSERT_FALSE(refusal) << name;
    EXPECT_NE(refusal.error().message.find(name), std::string::npos) << refusal.error().message;
  }
}

}  // namespace
}  // namespace palpate::server::physics
