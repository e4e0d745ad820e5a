#include "palpate/server/graphics/conditions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace palpate::server::graphics {
namespace {

using device::HealthCode;

// A camera of 30 Hz and a tracker of 100 Hz that both look well, and what a test makes of them.
struct Devices {
  bool images = true, samples = true, head = true, agree = true;
  int width = 640, height = 480, predicted = 12;
};

class WatchedDevices {
 public:
  // Looks each millisecond from where it stopped until `until_s`.
  void run(double until_s, const Devices& devices = {}) {
    for (; ms_ < static_cast<int>(1000.0 * until_s); ++ms_) {
      const Instant<GraphicsClock> now{std::chrono::milliseconds(ms_)};
      if (devices.samples && ms_ % 10 == 0) watch_.tracker_sample(now, true, devices.head);
      if (devices.images && ms_ % 33 == 0 && watch_.image(now, devices.width, devices.height))
        watch_.landmarks(now, devices.predicted, devices.agree ? 12 : 2, devices.agree);
      watch_.look(now);
      if (watch_.health().conditions().size() > most_) most_ = watch_.health().conditions().size();
      if (first_s_ < 0.0 && !watch_.health().conditions().empty()) first_s_ = 1e-3 * ms_;
    }
  }
  ConditionWatch& watch() { return watch_; }
  const std::vector<Condition>& now() const { return watch_.health().conditions(); }
  double first_s() const { return first_s_; }  // when anything was first told; below 0: never
  std::size_t most() const { return most_; }   // conditions at a time

 private:
  ConditionWatch watch_{640, 480};
  int ms_ = 0;
  double first_s_ = -1.0;
  std::size_t most_ = 0;
};

TEST(ConditionWatch, TellsEachFaultAloneWithinHalfASecondAndItsEnd) {
  struct Case {
    std::function<void(Devices&)> breaks;
    HealthCode code;
  };
  const std::vector<Case> cases = {
      {[](Devices& d) { d.images = false; }, HealthCode::camera_silent},
      {[](Devices& d) { d.width = 320; }, HealthCode::image_size},
      {[](Devices& d) { d.samples = false; }, HealthCode::tracker_silent},
      {[](Devices& d) { d.head = false; }, HealthCode::tracker_blind},
      {[](Devices& d) { d.agree = false; }, HealthCode::landmarks_lost},
  };
  for (const auto& one : cases) {
    WatchedDevices devices;
    devices.run(2.0);
    EXPECT_LT(devices.first_s(), 0.0) << name_of(one.code) << ": told while all was well";
    Devices broken;
    one.breaks(broken);
    devices.run(4.0, broken);
    ASSERT_EQ(devices.now().size(), 1u) << name_of(one.code);
    EXPECT_EQ(devices.now()[0].code, one.code);
    EXPECT_GT(devices.first_s(), 2.0);
    EXPECT_LE(devices.first_s(), 2.5) << name_of(one.code);
    EXPECT_EQ(devices.most(), 1u) << name_of(one.code) << ": and nothing that only follows from it";
    devices.run(4.1);
    EXPECT_TRUE(devices.now().empty()) << name_of(one.code);
  }
}

TEST(ConditionWatch, AskedForLandmarksOnlyWhereSomeShouldBeInView) {
  WatchedDevices devices;
  Devices none;
  none.predicted = 0;
  none.agree = false;
  devices.run(3.0, none);
  EXPECT_LT(devices.first_s(), 0.0);
}

// The camera begins later than whoever looks, and its first two pictures are seen before the tracker's clock
// is known well.
TEST(ConditionWatch, TheFirstPicturesWithoutLandmarksAreNoNews) {
  ConditionWatch watch(640, 480);
  int told = 0;
  const auto run = [&](int from_ms, int to_ms, bool images, bool agree) {
    for (int ms = from_ms; ms < to_ms; ms += 10) {
      const Instant<GraphicsClock> now{std::chrono::milliseconds(ms)};
      watch.tracker_sample(now, true, true);
      if (images && ms % 30 == 0) {
        watch.image(now, 640, 480);
        watch.landmarks(now, 12, agree ? 12 : 0, agree);
      }
      watch.look(now);
      for (const auto& one : watch.health().conditions()) told += one.code == HealthCode::landmarks_lost;
    }
  };
  run(0, 600, false, false);
  run(600, 660, true, false);
  run(660, 2000, true, true);
  EXPECT_EQ(told, 0);
  run(2010, 3000, true, false);
  EXPECT_GT(told, 0);
}

TEST(ConditionWatch, ADriverIsBelievedInItsOwnWords) {
  WatchedDevices devices;
  devices.watch().set_camera_health(std::nullopt);
  devices.run(1.0);
  Devices silent;
  silent.images = false;
  devices.run(1.3, silent);
  EXPECT_TRUE(devices.now().empty()) << "a slow camera whose driver is content";
  devices.watch().set_camera_health(
      device::HealthReport{HealthCode::camera_lost, "camera v4l2: unplugged; plug it in again"});
  devices.run(1.31, silent);
  ASSERT_EQ(devices.now().size(), 1u);
  EXPECT_EQ(devices.now()[0].code, HealthCode::camera_lost);
  EXPECT_EQ(devices.now()[0].words, "camera v4l2: unplugged; plug it in again");
  const auto since = devices.now()[0].since;
  devices.watch().set_camera_health(device::HealthReport{
      HealthCode::camera_unfit, "camera v4l2: its pictures are 320x240 px; set it to 640x480"});
  devices.run(1.4, silent);
  ASSERT_EQ(devices.now().size(), 1u) << "one trouble of the camera";
  EXPECT_EQ(devices.now()[0].words, "camera v4l2: its pictures are 320x240 px; set it to 640x480");
  EXPECT_EQ(devices.now()[0].since, since);
  devices.watch().set_camera_health(std::nullopt);
  devices.run(1.5);
  EXPECT_TRUE(devices.now().empty());
}

TEST(ConditionWatch, AtMostFourHoldAtTheSameTime) {
  // What travels to `palpate status` is made for four.
  std::size_t most = 0;
  for (int bits = 0; bits < 32; ++bits) {
    Devices broken;
    broken.images = (bits & 1) == 0;
    broken.width = (bits & 2) == 0 ? 640 : 320;
    broken.samples = (bits & 4) == 0;
    broken.head = (bits & 8) == 0;
    broken.agree = (bits & 16) == 0;
    WatchedDevices devices;
    devices.run(1.0);
    devices.watch().camera_clock_set({std::chrono::milliseconds(1000)});
    devices.watch().tracker_clock_set({std::chrono::milliseconds(1000)});
    devices.run(1.9, broken);
    most = std::max(most, devices.most());
  }
  EXPECT_EQ(most, 4u);
}

TEST(ConditionWatch, AnotherSceneIsToldAtOnceAndWhatComesAfterItWhenItHasStoodForASecond) {
  WatchedDevices devices;
  devices.run(1.0);
  const auto at = [](double s) { return Instant<GraphicsClock>{seconds(s)}; };
  devices.watch().scene_described(at(1.0), "plays touch", std::nullopt);
  devices.run(1.01);
  ASSERT_EQ(devices.now().size(), 1u);
  EXPECT_EQ(devices.now()[0].code, HealthCode::other_scene);
  EXPECT_EQ(devices.now()[0].words, "plays touch");
  devices.watch().scene_described(at(1.5), "plays jelly", "table elsewhere");
  devices.run(2.4);
  ASSERT_EQ(devices.now().size(), 2u);
  EXPECT_EQ(devices.now()[0].words, "plays touch");
  EXPECT_EQ(devices.now()[1].code, HealthCode::other_rig);
  EXPECT_EQ(devices.now()[1].words, "table elsewhere");
  devices.run(2.6);
  EXPECT_EQ(devices.now()[0].words, "plays jelly");
  devices.watch().scene_described(at(2.6), std::nullopt, std::nullopt);
  devices.run(3.5);
  EXPECT_EQ(devices.now().size(), 2u) << "one that changes all the time does not fill a log";
  devices.run(3.7);
  EXPECT_TRUE(devices.now().empty());
}

TEST(ConditionWatch, WhoKnowsWhyATrackerIsSilentSaysItAndWhatChangesMeanwhile) {
  WatchedDevices devices;
  std::string why = "tracker: no server answers";
  int asked = 0;
  devices.watch().set_tracker_explanation([&] { return ++asked, why; });
  devices.run(2.0);
  EXPECT_EQ(asked, 0) << "nobody is asked while all is well";
  Devices silent;
  silent.samples = false;
  devices.run(2.5, silent);
  ASSERT_EQ(devices.now().size(), 1u);
  EXPECT_EQ(devices.now()[0].code, HealthCode::tracker_silent);
  EXPECT_EQ(devices.now()[0].words, why);
  why = "tracker: sends no such tool";
  devices.run(2.6, silent);
  EXPECT_EQ(devices.now()[0].words, why);
  Devices blind;
  blind.head = false;
  devices.run(3.5, blind);
  ASSERT_EQ(devices.now().size(), 1u);
  EXPECT_EQ(devices.now()[0].code, HealthCode::tracker_blind);
  EXPECT_EQ(devices.now()[0].words, why);
  devices.run(4.0);
  EXPECT_TRUE(devices.now().empty());
}

}  // namespace
}  // namespace palpate::server::graphics
