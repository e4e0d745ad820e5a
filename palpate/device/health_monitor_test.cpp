#include "palpate/device/health_monitor.h"

#include <gtest/gtest.h>

#include <set>

namespace palpate::device {
namespace {

using Monitor = HealthMonitor<GraphicsClock>;
using enum HealthCode;

Instant<GraphicsClock> at(int ms) { return {std::chrono::milliseconds(ms)}; }

TEST(Health, EveryCodeHasANameAnEndAndASubjectThatIsItsOwn) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kHealthCodes; ++i) {
    const auto code = static_cast<HealthCode>(i);
    EXPECT_TRUE(names.insert(name_of(code)).second) << name_of(code);
    EXPECT_FALSE(end_of(code).empty()) << name_of(code);
    EXPECT_EQ(subject_of(subject_of(code)), subject_of(code)) << name_of(code);
  }
  EXPECT_EQ(name_of(camera_silent), "camera_silent");
  EXPECT_EQ(name_of(physics_server_gone), "physics_server_gone");
}

TEST(HealthMonitor, TellsABeginningAndAnEndOnceHoweverOftenItIsAsked) {
  const LogCapture told;
  Monitor monitor(Log("graphics"));
  for (int ms = 100; ms < 200; ++ms) monitor.set(true, {tracker_silent, "tracker: no samples"}, at(ms));
  ASSERT_EQ(monitor.conditions().size(), 1u);
  EXPECT_EQ(monitor.conditions()[0].since, at(100));
  EXPECT_EQ(monitor.conditions()[0].severity(), Severity::fault);
  for (int ms = 200; ms < 300; ++ms) monitor.set(false, {tracker_silent, ""}, at(ms));
  EXPECT_TRUE(monitor.conditions().empty());
  EXPECT_EQ(told.text(), "graphics: tracker: no samples\ngraphics: tracker: samples come again\n");
  EXPECT_EQ(told.lines()[0].level, LogLevel::warning);
  EXPECT_EQ(told.lines()[1].level, LogLevel::info);
  EXPECT_EQ(monitor.changes(), 2u);
}

TEST(HealthMonitor, OtherWordsAreToldAndDoNotBeginItAnew) {
  const LogCapture told;
  Monitor monitor(Log("graphics"));
  monitor.set(true, {tracker_silent, "no server answers"}, at(1));
  monitor.set(true, {tracker_silent, "sends no such tool"}, at(2));
  EXPECT_EQ(monitor.conditions()[0].since, at(1));
  EXPECT_EQ(told.text(), "graphics: no server answers\ngraphics: sends no such tool\n");
  EXPECT_EQ(monitor.begun().at("tracker_silent"), 1);
}

TEST(HealthMonitor, WordsThatChangeWithEachImageStayThoseOfTheBeginning) {
  const LogCapture told;
  Monitor monitor(Log("graphics"));
  for (int used = 0; used < 3; ++used)
    monitor.set(true, {landmarks_lost, fmt::format("landmarks: {} agree", used)}, at(used));
  EXPECT_EQ(monitor.conditions()[0].words, "landmarks: 0 agree");
  EXPECT_EQ(told.lines().size(), 1u);
  for (const char* words : {"camera v4l2: unplugged", "camera v4l2: there is no such device"})
    monitor.set(true, {camera_lost, words}, at(9));
  EXPECT_EQ(monitor.conditions()[1].words, "camera v4l2: unplugged") << "while it is looked for";
  EXPECT_EQ(told.lines().size(), 2u);
}

TEST(HealthMonitor, ReportsOfOneSubjectTakeEachOthersPlaceWithoutAnEndBetweenThem) {
  const LogCapture told;
  Monitor monitor(Log("graphics"));
  monitor.set(true, {camera_silent, "camera: no image any more"}, at(1));
  monitor.set(true, {image_size, "camera: images have 320 x 240 pixels"}, at(2));
  monitor.set(true, {camera_lost, "camera v4l2: unplugged"}, at(3));
  ASSERT_EQ(monitor.conditions().size(), 2u);
  EXPECT_EQ(monitor.conditions()[0].code, camera_lost) << "in its place, the oldest";
  EXPECT_EQ(monitor.conditions()[0].since, at(1));
  EXPECT_EQ(monitor.conditions()[1].code, image_size);
  EXPECT_EQ(monitor.begun(),
            (std::map<std::string, int>{{"camera_silent", 1}, {"image_size", 1}, {"camera_lost", 1}}));
  EXPECT_EQ(told.lines().size(), 3u);
  EXPECT_EQ(told.text().find("again"), std::string::npos) << told.text();
}

TEST(HealthMonitor, ADeviceThatIsFollowedEndsInTheWordsOfItsLastReport) {
  const LogCapture told;
  HealthMonitor<PhysicsClock> monitor(Log("physics"));
  monitor.follow(std::nullopt, {});
  const HealthReport lost{arm_lost, "arm: unplugged", "arm: works again; see that it knows where it is"};
  monitor.follow(lost, {});
  monitor.follow(std::nullopt, {});
  EXPECT_EQ(told.text(),
            "physics: arm: unplugged\nphysics: arm: works again; see that it knows where it is\n");
  monitor.follow(lost, {});
  monitor.follow(HealthReport{arm_forces_off, "arm: too warm"}, {});
  monitor.follow(std::nullopt, {});
  const auto lines = told.lines();
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[3].text, "physics: arm: too warm");
  EXPECT_EQ(lines[4].text, "physics: arm: works again");
  EXPECT_TRUE(monitor.conditions().empty());
}

TEST(HealthMonitor, WithoutALogNobodyIsTold) {
  const LogCapture told;
  Monitor monitor;
  monitor.set(true, {camera_silent, "camera: no image any more"}, at(1));
  monitor.follow(std::nullopt, at(2));
  EXPECT_EQ(told.text(), "");
  EXPECT_EQ(monitor.changes(), 2u);
}

}  // namespace
}  // namespace palpate::device
