#include "drivers/cameras/live_camera.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>

#include "drivers/cameras/camera_choice.h"
#include "palpate/device/health_monitor.h"

namespace palpate::drivers::cameras {
namespace {

enum class Does { run, rest, damage, shrink, vanish, end };

// What a test makes a camera do, from its own thread.
struct Script {
  std::atomic<Does> does{Does::run};
  std::atomic<std::uint64_t> made{0};
  std::atomic<int> opened{0}, closed{0};
  std::atomic<std::int64_t> handed_ns{0};  // when the latest picture left it, CLOCK_MONOTONIC
  std::atomic<std::int64_t> way_ns{0};     // how long it was on its way, where the source can tell
};

std::int64_t stopwatch_ns() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

class ScriptedSource : public FrameSource {
 public:
  explicit ScriptedSource(Script& script) : script_(script) {}
  const std::string& name() const override { return name_; }
  Expected<CameraFacts> try_open() override {
    if (script_.does == Does::vanish) return refused("camera scripted: there is no such device");
    ++script_.opened;
    CameraFacts facts;
    facts.width = 8, facts.height = 4, facts.rate_hz = 100.0;
    return facts;
  }
  Outcome wait(Duration) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    Outcome outcome;
    switch (script_.does.load()) {
      case Does::rest:
        return outcome;
      case Does::vanish:
        return {Outcome::Kind::lost, {}, "it was unplugged; plug it in again"};
      case Does::end:
        return {Outcome::Kind::ended, {}, {}};
      case Does::damage:
        return {Outcome::Kind::damaged, {}, "a picture was damaged on its way"};
      default:
        break;
    }
    const int width = script_.does == Does::shrink ? 4 : 8;
    const std::uint64_t number = ++script_.made;
    bytes_.assign(static_cast<std::size_t>(width * 4 * 3), static_cast<std::uint8_t>(number));
    outcome.kind = Outcome::Kind::frame;
    script_.handed_ns = stopwatch_ns();
    outcome.frame.mid_exposure_ns = static_cast<std::int64_t>(number) * 1000;
    outcome.frame.number = number;
    if (script_.way_ns != 0) outcome.frame.taken_ns = script_.handed_ns - script_.way_ns;
    outcome.frame.picture = {PixelFormat::rgb8, width, 4, 0, bytes_};
    return outcome;
  }
  void close() override { ++script_.closed; }

 private:
  Script& script_;
  std::vector<std::uint8_t> bytes_;
  const std::string name_ = "scripted";
};

void wait_for(const std::function<bool()>& condition, const char* what) {
  const auto begun = std::chrono::steady_clock::now();
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(60)) << what;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// What a person is told of it.
class Watched {
 public:
  explicit Watched(LiveCamera& camera) : camera_(camera) {}
  void look() { monitor_.follow(camera_.status().health, {}); }
  bool silent() { return look(), told_.lines().size() == heard_; }
  std::string next_news() {
    wait_for([&] { return !silent(); }, "news");
    const auto lines = told_.lines();
    return heard_ < lines.size() ? lines[heard_++].text : "";
  }

 private:
  LiveCamera& camera_;
  LogCapture told_;
  device::HealthMonitor<GraphicsClock> monitor_{Log()};
  std::size_t heard_ = 0;
};

TEST(LiveCamera, HandsOverTheNewestPictureOnceAndDropsOlderOnes) {
  Script script;
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script), 8, 4);
  ASSERT_TRUE(camera);
  wait_for([&] { return script.made > 20; }, "twenty pictures");
  script.does = Does::rest;
  const auto made = script.made.load();
  // The latest one may still be on its way into the slot; whichever is there, it is whole and agrees with
  // itself.
  std::optional<device::CameraImage> image;
  wait_for(
      [&] {
        if (auto next = (*camera)->poll()) image = std::move(next);
        return image && image->frame == script.made;
      },
      "the newest");
  EXPECT_GE(image->frame, made);
  EXPECT_EQ(image->mid_exposure.ns(), static_cast<std::int64_t>(image->frame) * 1000);
  EXPECT_EQ(image->rgb, std::vector<std::uint8_t>(96, static_cast<std::uint8_t>(image->frame)));
  EXPECT_FALSE((*camera)->poll());
  EXPECT_GT((*camera)->status().pictures, 20u);
  EXPECT_EQ((*camera)->status().dropped, 0u);
}

// Beside a stopwatch: not less than it has lain in the slot, not more than since it left its source.
TEST(LiveCamera, APictureSaysHowLongItHasWaitedToBeAskedFor) {
  Script script;
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script));
  ASSERT_TRUE(camera);
  wait_for([&] { return script.made > 3; }, "pictures");
  script.does = Does::rest;
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // the latest may be on its way into the slot
  wait_for([&] { return (*camera)->status().pictures == script.made; }, "the newest");
  const auto there = stopwatch_ns();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const auto asked = stopwatch_ns();
  const auto image = (*camera)->poll();
  const auto taken = stopwatch_ns();
  ASSERT_TRUE(image);
  EXPECT_GE(image->waited.count(), asked - there);
  EXPECT_LE(image->waited.count(), taken - script.handed_ns);
}

TEST(LiveCamera, APictureThatTellsWhenItWasTakenHasWaitedSinceThenAndIsNoneTheLessNew) {
  Script script;
  script.way_ns = 700'000'000;  // longer than one is silent for
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script));
  ASSERT_TRUE(camera);
  wait_for([&] { return script.made > 3; }, "pictures");
  Watched watched(**camera);
  EXPECT_TRUE(watched.silent());
  std::optional<device::CameraImage> image;
  wait_for([&] { return (image = (*camera)->poll()).has_value(); }, "a picture");
  EXPECT_GE(image->waited.count(), script.way_ns);
}

TEST(LiveCamera, SaysThatFramesStoppedAndThatTheyCameBack) {
  Script script;
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script));
  ASSERT_TRUE(camera);
  wait_for([&] { return script.made > 3; }, "pictures");
  Watched watched(**camera);
  EXPECT_TRUE(watched.silent());
  script.does = Does::rest;
  EXPECT_EQ(watched.next_news().find("camera scripted: no picture comes any more; see to its cable"), 0u);
  script.does = Does::run;
  EXPECT_EQ(watched.next_news(), "camera scripted: works again");
}

TEST(LiveCamera, KnowsThatFramesStoppedHoweverRarelyItIsAsked) {
  Script script;
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script));
  ASSERT_TRUE(camera);
  wait_for([&] { return script.made > 3; }, "pictures");
  EXPECT_FALSE((*camera)->status().health);
  script.does = Does::rest;
  // As a graphics server asks that draws for a second: this is its first question since.
  std::this_thread::sleep_for(3 * LiveCamera::kSilence);
  EXPECT_TRUE((*camera)->status().health);
}

TEST(LiveCamera, SaysWhyNoneOfThePicturesIsOfUse) {
  Script script;
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script), 8, 4);
  ASSERT_TRUE(camera);
  wait_for([&] { return script.made > 3; }, "pictures");
  Watched watched(**camera);
  script.does = Does::shrink;
  EXPECT_EQ(watched.next_news(),
            "camera scripted: its pictures are 4x4 px and the lens was calibrated at 8x4; set the camera to "
            "that size, or calibrate it anew (palpate calibrate camera)");
  EXPECT_EQ((*camera)->status().health.value().code, device::HealthCode::camera_unfit);
  script.does = Does::damage;
  EXPECT_EQ(watched.next_news(), "camera scripted: a picture was damaged on its way");
  script.does = Does::run;
  EXPECT_EQ(watched.next_news(), "camera scripted: works again");
  EXPECT_GT((*camera)->status().damaged, 1u);
}

TEST(LiveCamera, OpensACameraThatWasUnpluggedAgainWithoutBeingAsked) {
  Script script;
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script));
  ASSERT_TRUE(camera);
  wait_for([&] { return script.made > 3; }, "pictures");
  Watched watched(**camera);
  script.does = Does::vanish;
  const auto news = watched.next_news();
  EXPECT_TRUE(news == "camera scripted: it was unplugged; plug it in again" ||
              news == "camera scripted: there is no such device")
      << news;
  wait_for([&] { return script.closed > 0; }, "closing");
  EXPECT_TRUE(watched.silent()) << "nothing new while it is looked for";
  script.does = Does::run;
  EXPECT_EQ(watched.next_news(), "camera scripted: works again");
  EXPECT_FALSE((*camera)->status().health);
  EXPECT_EQ(script.opened, 2);
  EXPECT_EQ((*camera)->status().times_opened, 2u);
}

TEST(LiveCamera, SaysOnceThatARecordingHasEnded) {
  Script script;
  auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script));
  ASSERT_TRUE(camera);
  Watched watched(**camera);
  script.does = Does::end;
  EXPECT_NE(watched.next_news().find("the recording has ended"), std::string::npos);
  EXPECT_TRUE(watched.silent());
}

TEST(LiveCamera, OneThatIsAbsentAtFirstIsRefused) {
  Script script;
  script.does = Does::vanish;
  const auto camera = LiveCamera::open(std::make_unique<ScriptedSource>(script));
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error().message, "camera scripted: there is no such device");
}

TEST(CameraChoice, NamesAKindAndWhichOfIt) {
  EXPECT_EQ(parse_choice("v4l2:2")->which, "/dev/video2");
  EXPECT_EQ(parse_choice("v4l2:/dev/v4l/by-id/usb-cam")->which, "/dev/v4l/by-id/usb-cam");
  EXPECT_EQ(parse_choice("v4l2")->which, "");
  EXPECT_EQ(parse_choice("aravis:192.168.0.7")->kind, Kind::aravis);
  EXPECT_EQ(parse_choice("images:a:b")->which, "a:b");
  EXPECT_EQ(parse_choice("video:x.mp4")->kind, Kind::video);
  for (const char* bad : {"", "webcam", "aravis:", "v4l2:", "images", "images:", "video:", "AVI:x"}) {
    const auto choice = parse_choice(bad);
    ASSERT_FALSE(choice) << bad;
    EXPECT_EQ(choice.error().kind, Error::Kind::wrong_use);
    EXPECT_NE(choice.error().message.find("aravis[:NAME]"), std::string::npos);
  }
}

TEST(CameraChoice, SettingsOutOfRangeOrOfARecordingAreWrongUse) {
  const Choice camera{Kind::v4l2, ""}, film{Kind::video, "x.mp4"};
  EXPECT_TRUE(check_settings(camera, {}));
  EXPECT_TRUE(check_settings(film, {}));
  const auto complains = [](const Choice& choice, const CameraSettings& settings, const char* words) {
    const auto fine = check_settings(choice, settings);
    ASSERT_FALSE(fine) << words;
    EXPECT_NE(fine.error().message.find(words), std::string::npos) << fine.error().message;
  };
  CameraSettings settings;
  settings.exposure_s = 0.0;
  complains(camera, settings, "0.001 to 10000 ms is expected");
  settings = {}, settings.rate_hz = 0.5;
  complains(camera, settings, "1 to 1000 Hz");
  settings = {}, settings.readout_s = -1.0;
  complains(camera, settings, "0 to 1000 ms");
  settings = {}, settings.pixel_format = "Mono12";
  complains(camera, settings, "'Mono12'");
  settings = {}, settings.gain = 3.0;
  complains(film, settings, "leave those options out");
}

}  // namespace
}  // namespace palpate::drivers::cameras
