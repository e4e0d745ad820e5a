#include "palpate/record/session/recorded_drivers.h"

#include <gtest/gtest.h>

#include <deque>

#include "palpate/record/recording_for_tests.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/tick_messages.h"

namespace palpate::record::session {
namespace {

struct ScriptedTracker : device::OpenedTracker, device::TrackerDevice {
  device::TrackerDevice& device() override { return *this; }
  std::string why_unheard() const override { return "it sleeps"; }
  std::vector<device::TrackerSample> poll() override {
    device::TrackerSample seen, unseen;
    seen.seen = true;
    seen.stamp = {Duration(++polls)};
    seen.translation = {0.1 * polls, 0.0, 0.0};
    unseen.marker = device::MarkerId::pointer;
    return {seen, unseen};
  }
  int polls = 0;
};

struct ScriptedCamera : device::OpenedCamera, device::CameraDevice {
  device::CameraDevice& device() override { return *this; }
  std::string name() const override { return "scripted"; }
  std::string description() const override { return "of a test"; }
  double exposure_s() const override { return 0.25; }
  std::optional<device::CameraImage> poll() override {
    device::CameraImage image;
    image.mid_exposure = {Duration(1000 * ++frames)};
    image.frame = static_cast<std::uint64_t>(frames);
    image.width = 4;
    image.height = 2;
    image.rgb.assign(24, static_cast<std::uint8_t>(frames));
    return image;
  }
  int frames = 0;
};

struct ScriptedArm : device::OpenedArm, device::ArmDevice {
  device::ArmDevice& device() override { return *this; }
  device::ArmFacts facts() const override { return {.simulated = true, .identity = "scripted"}; }
  device::ArmSample read() override {
    device::ArmSample sample;
    sample.stamp = {Duration(++reads / 2)};  // each reading is there twice
    return sample;
  }
  void command(const Vector3& force) override { commanded = force; }
  void let_go() noexcept override {}
  int reads = 0;
  Vector3 commanded = Vector3::Zero();
};

template <typename Opener, typename Device>
Opener opener_of() {
  Opener opener;
  opener.form = "scripted";
  opener.open = [](const typename Opener::Request&) -> Expected<std::unique_ptr<typename Opener::Opened>> {
    return std::make_unique<Device>();
  };
  return opener;
}

device::DriverRegistry scripted() {
  device::DriverRegistry registry;
  registry.add(device::Driver{.scheme = "scripted",
                              .summary = "devices of a test",
                              .arm = opener_of<device::ArmOpener, ScriptedArm>(),
                              .tracker = opener_of<device::TrackerOpener, ScriptedTracker>(),
                              .camera = opener_of<device::CameraOpener, ScriptedCamera>()});
  return registry;
}

// What was heard on a topic, after the devices are gone.
struct Session {
  ScratchFolder folder;
  std::unique_ptr<SessionRecording> recording =
      std::move(*SessionRecording::begin(folder / "s.mcap", {.recorder = "test", .on_error = {}}));
  std::vector<HeardLine> heard(const std::string& topic) {
    recording->close();
    std::vector<HeardLine> lines;
    for (auto& line : lines_of(*read_file(folder / "s.mcap")))
      if (line.topic == topic) lines.push_back(std::move(line));
    return lines;
  }
};

TEST(RecordedDrivers, TrackerSamplesAreWrittenAndHandedOn) {
  Session session;
  {
    const auto drivers = recorded_drivers(scripted(), *session.recording);
    auto tracker = drivers.open(device::TrackerRequest{"scripted", {}});
    ASSERT_TRUE(tracker) << tracker.error().message;
    EXPECT_EQ((*tracker)->why_unheard(), "it sleeps");
    for (int i = 1; i <= 3; ++i) {
      const auto samples = (*tracker)->device().poll();
      ASSERT_EQ(samples.size(), 2u);
      EXPECT_EQ(samples[0].translation.x(), 0.1 * i);
    }
  }
  const auto lines = session.heard("/tracker/sample");
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0].schema, "palpate.recording.TrackerSample");
  const auto third = decode_tracker_sample(lines[4].data);
  ASSERT_TRUE(third);
  EXPECT_EQ(third->sample.translation.x(), 0.1 * 3);
  EXPECT_EQ(third->sample.stamp.ns(), 3);
  EXPECT_FALSE(decode_tracker_sample(lines[5].data)->sample.seen);
}

TEST(RecordedDrivers, PicturesAreWrittenOnlyWhereTheyAreAskedFor) {
  for (const bool wanted : {false, true}) {
    Session session;
    {
      const auto drivers = recorded_drivers(scripted(), *session.recording, {.lossless = wanted});
      auto camera = drivers.open(device::CameraRequest{"scripted", {}});
      ASSERT_TRUE(camera);
      EXPECT_EQ((*camera)->exposure_s(), 0.25);
      const auto image = (*camera)->device().poll();
      ASSERT_TRUE(image);
      EXPECT_EQ(image->rgb.size(), 24u);
    }
    const auto stamps = session.heard("/camera/left/stamp");
    ASSERT_EQ(stamps.size(), 1u);
    const auto stamp = decode_camera_stamp(stamps[0].data);
    ASSERT_TRUE(stamp);
    EXPECT_EQ(stamp->image.frame, 1u);
    EXPECT_EQ(stamp->image.mid_exposure.ns(), 1000);
    EXPECT_EQ(session.heard("/camera/left/image").size(), wanted ? 1u : 0u);
  }
}

TEST(RecordedDrivers, AnArmIsCommandedAsEverAndEachReadingIsWrittenOnce) {
  Session session;
  {
    const auto drivers = recorded_drivers(scripted(), *session.recording);
    auto arm = drivers.open(device::ArmRequest{.uri = "scripted", .nominal = {}});
    ASSERT_TRUE(arm);
    EXPECT_EQ((*arm)->facts().identity, "scripted");
    for (int i = 0; i < 9; ++i) (*arm)->device().read();
    (*arm)->device().command({1.0, 0.0, 0.0});
  }
  const auto lines = session.heard("/arm/sample");
  ASSERT_EQ(lines.size(), 5u);
  const auto last = decode_sample(lines.back().data);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->tick.sample.stamp.ns(), 4);
  EXPECT_FALSE(last->inputs.exact) << "of no haptic loop: it cannot be executed again";
}

TEST(SessionRecordingTest, AMessageThatIsNoneIsAMistakeOfTheProgram) {
  Session session;
  EXPECT_THROW(session.recording->stream("/x", "palpate.recording.Nothing"), std::invalid_argument);
  EXPECT_EQ(&session.recording->stream("/x", "foxglove.Log"),
            &session.recording->stream("/x", "foxglove.Log"));
}

TEST(SessionRecordingTest, AFileThatIsThereIsLeftAlone) {
  Session session;
  const auto again = SessionRecording::begin(session.folder / "s.mcap", {.recorder = "test", .on_error = {}});
  EXPECT_FALSE(again);
}

}  // namespace
}  // namespace palpate::record::session
