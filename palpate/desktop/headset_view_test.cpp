// Frames of the graphics server in a headset, through OpenXR's loader and the test runtime.
#include "palpate/desktop/headset_view.h"

#include <gtest/gtest.h>

#include "palpate/headset/headset_for_tests.h"

namespace palpate::desktop {
namespace {

class HeadsetViewTest : public headset::HeadsetTest {
 protected:
  void open_view(const HeadsetViewOptions& options = {}) {
    open();
    auto lettering = Lettering::open();
    if (!lettering) throw std::runtime_error(lettering.error().message);
    view = HeadsetView::on(std::move(headset), std::move(*lettering), scene, options);
  }
  ~HeadsetViewTest() override {
    runtime.run_by_itself();
    view.reset();
  }
  server::graphics::FrameRecord frame() const {
    server::graphics::FrameRecord record;
    record.width = 640;
    record.height = 480;
    record.rgb.assign(640 * 480 * 3, 90);
    record.image_time = now() - std::chrono::milliseconds(60);
    return record;
  }
  // What stands in the middle of an eye's view, and how much of the view is neither black nor that.
  int middle() const {
    const auto seen = runtime.seen(0, runtime.counts().display_ns);
    return seen.rgb[3 * (240 * 480 + 240)];
  }

  scene::SceneDescription scene;
  std::unique_ptr<HeadsetView> view;
};

TEST_F(HeadsetViewTest, ShowsFramesThatHaveAPicture) {
  open_view();
  refresh(8);
  view->show({}, now());
  refresh();
  EXPECT_EQ(runtime.counts().quads, 0U);
  view->show(frame(), now());
  refresh();
  EXPECT_EQ(middle(), 90);
  EXPECT_EQ(view->figures()["pictures_shown"], 1);
}

TEST_F(HeadsetViewTest, TheirAgeIsThatAtWhichTheyAreSeen) {
  open_view();
  refresh(8);
  const auto record = frame();
  view->show(record, now());
  refresh();
  view->act({}, now());
  const double age_ms = 1e-6 * static_cast<double>(runtime.counts().display_ns - record.image_time.ns());
  EXPECT_NEAR(view->figures()["age_ms"]["median"].get<double>(), age_ms, 1e-3);
}

TEST_F(HeadsetViewTest, StandsThePictureAtTheTip) {
  open_view();
  refresh(8);
  auto record = frame();
  record.pose_source = server::graphics::PoseSource::tracker;
  record.have_state = true;
  record.state.bodies[scene::kCarried].position = {0.0, 0.0, 0.93};
  view->show(record, now());
  EXPECT_NEAR(view->figures()["distance_m"].get<double>(), 0.93, 1e-12);
}

TEST_F(HeadsetViewTest, OrWhereOneIsTold) {
  open_view({.distance = 1.5, .clock = {}});
  view->show(frame(), now());
  EXPECT_EQ(view->figures()["distance_m"], 1.5);
}

TEST_F(HeadsetViewTest, ScoreAndWarningsStandBeforeTheEyesAsLongAsThereAreAny) {
  open_view();
  refresh(8);
  view->show(frame(), now());
  HudContent content;
  content.score = {"rally 3"};
  content.warnings = {"The tracker does not see the camera's marker"};
  view->act(content, now());
  refresh();
  EXPECT_EQ(runtime.counts().quads, 2U);
  const auto uploads = runtime.counts().uploads;
  refresh(5);
  view->act(content, now());
  refresh();
  EXPECT_EQ(runtime.counts().uploads, uploads) << "the same words are not drawn again";
  refresh(5);
  view->act({}, now());
  refresh();
  EXPECT_EQ(runtime.counts().quads, 1U);
}

TEST_F(HeadsetViewTest, WhatIsSaidStandsThereForSomeSeconds) {
  open_view();
  refresh(8);
  view->show(frame(), now());
  const auto said_at = now();
  view->say("Pictures at quality low from here on", said_at);
  view->act({}, said_at);
  refresh();
  EXPECT_EQ(runtime.counts().quads, 2U);
  view->act({}, said_at + std::chrono::milliseconds(5900));
  refresh();
  EXPECT_EQ(runtime.counts().quads, 2U);
  view->act({}, said_at + std::chrono::milliseconds(6100));
  refresh();
  EXPECT_EQ(runtime.counts().quads, 1U);
}

TEST_F(HeadsetViewTest, WordsReturnWithTheRuntime) {
  settings.retry = std::chrono::milliseconds(20);
  open_view();
  refresh(8);
  HudContent content;
  content.score = {"rally 3"};
  auto at = now();
  const auto told = [&](bool trouble) {
    at += std::chrono::milliseconds(60);
    view->act(content, at);
    return view->trouble().has_value() == trouble;
  };
  told(false);
  refresh();
  EXPECT_EQ(runtime.counts().quads, 1U);
  runtime.vanish();
  ASSERT_TRUE(headset::comes_to_be([&] { return told(true); }));
  runtime.return_again();
  ASSERT_TRUE(headset::comes_to_be([&] { return runtime.refresh(0.01) && told(false); }));
  refresh();
  EXPECT_EQ(runtime.counts().quads, 1U);
}

TEST_F(HeadsetViewTest, TellsTheLogOnceThatTheRuntimeHasGoneAndOnceThatItIsBack) {
  settings.retry = std::chrono::milliseconds(20);
  open_view();
  refresh(3);
  const LogCapture log;
  auto at = now();
  const auto told = [&](bool trouble) {
    at += std::chrono::milliseconds(60);
    view->act({}, at);
    return view->trouble().has_value() == trouble;
  };
  runtime.vanish();
  ASSERT_TRUE(headset::comes_to_be([&] { return told(true); }));
  for (int i = 0; i < 5; ++i) told(true);
  runtime.return_again();
  ASSERT_TRUE(headset::comes_to_be([&] { return runtime.refresh(0.01) && told(false); }));
  ASSERT_EQ(log.lines().size(), 2U) << log.text();
  EXPECT_EQ(log.lines()[0].level, LogLevel::warning);
  EXPECT_NE(log.lines()[0].text.find("XR_ERROR_INSTANCE_LOST"), std::string::npos) << log.text();
  EXPECT_NE(log.lines()[1].text.find("again"), std::string::npos) << log.text();
}

TEST(StackedWords, AreAsWideAsTheWidestAndNoneWhereNothingIsSaid) {
  auto lettering = Lettering::open();
  ASSERT_TRUE(lettering) << lettering.error().message;
  Hud hud(std::move(*lettering));
  std::uint64_t version = 0, later = 0;
  EXPECT_EQ(stacked_words(hud, {}, {}, &version).width, 0);
  HudContent content;
  content.score = {"rally 3"};
  content.hint = "a hint for the desk";
  const Canvas score = stacked_words(hud, content, {}, &version);
  EXPECT_GT(score.width, 0);
  content.warnings = {"No landmarks are found in the picture"};
  const Canvas both = stacked_words(hud, content, {}, &later);
  EXPECT_GT(both.width, score.width);
  EXPECT_GT(both.height, score.height);
  EXPECT_NE(version, later);
  const Canvas three = stacked_words(hud, content, "Pictures at quality low from here on", &later);
  EXPECT_GT(three.height, both.height);
}

}  // namespace
}  // namespace palpate::desktop
