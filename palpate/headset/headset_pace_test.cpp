// The headset goes on at its own rate, whatever becomes of who hands pictures over.
#include <gtest/gtest.h>

#include "palpate/headset/headset_for_tests.h"

namespace palpate::headset {
namespace {

class HeadsetPace : public HeadsetTest {
 protected:
  void show_a_picture() {
    const std::vector<std::uint8_t> rgb(640 * 480 * 3, 77);
    headset->show({rgb, 640, 480, now(), 0.6});
  }
  // Share of the display's refreshes in `s` of virtual time that got a frame with the picture, while nobody hands
  // anything over.
  double share_while_nothing_comes(double s) {
    const TestCounts before = runtime.counts();
    const auto refreshes = static_cast<int>(s * 1e9 / static_cast<double>(runtime.period_ns()));
    for (int i = 0; i < refreshes; ++i) runtime.refresh();
    const TestCounts after = runtime.counts();
    EXPECT_EQ(after.refreshes - before.refreshes, static_cast<std::uint64_t>(refreshes));
    const double share =
        static_cast<double>(after.with_layers - before.with_layers) / static_cast<double>(refreshes);
    RecordProperty("share_with_picture", std::to_string(share));
    return share;
  }
};

TEST_F(HeadsetPace, IsTheDisplaysWhileTheFrameLoopStandsStill) {
  open();
  refresh(3);
  show_a_picture();
  refresh();
  for (const double s : {0.1, 1.0, 10.0}) {
    EXPECT_GE(share_while_nothing_comes(s), 0.95) << s;
    show_a_picture();
    refresh();
  }
  EXPECT_EQ(runtime.counts().uploads, 4U) << "a picture that stays is not copied again";
  EXPECT_EQ(headset->facts().pictures_shown, 4U);
}

// Not even where whoever hands over has died in the middle of it: the last picture stays.
TEST_F(HeadsetPace, NobodyIsWaitedForWhoIsSlowerOrFasterThanTheDisplay) {
  open();
  refresh(3);
  for (int i = 0; i < 7; ++i) show_a_picture();
  refresh(2);
  EXPECT_EQ(headset->facts().pictures, 7U);
  EXPECT_EQ(headset->facts().pictures_shown, 1U) << "the newest; the others were replaced";
  ASSERT_TRUE(headset->shown());
  EXPECT_EQ(headset->shown()->picture, 7U);
}

TEST_F(HeadsetPace, ShowsNothingBeforeThereIsAPicture) {
  open();
  refresh(5);
  EXPECT_EQ(runtime.counts().frames, 5U);
  EXPECT_EQ(runtime.counts().with_layers, 0U);
  EXPECT_EQ(headset->facts().with_picture, 0U);
}

TEST_F(HeadsetPace, SaysWhenAPictureWillBeSeen) {
  open();
  refresh(5);
  // Handed over now, just after a frame was asked for: the next one has it.
  const auto expected = headset->display_time(now() + Duration(1));
  show_a_picture();
  refresh();
  ASSERT_TRUE(headset->shown());
  // Whole nanoseconds, and the period is rounded to one.
  EXPECT_NEAR(static_cast<double>((headset->shown()->displayed - expected).count()), 0.0, 1.0);
  EXPECT_EQ(headset->shown()->displayed.ns(), runtime.counts().display_ns);
  refresh(4);
  EXPECT_EQ(headset->shown()->displayed.ns() + 4 * runtime.period_ns(), runtime.counts().display_ns)
      << "of the first frame that showed it";
}

TEST_F(HeadsetPace, TimesAreTheGraphicsHosts) {
  const double offset_s = 3.25;
  settings.clock = MonotonicClock<GraphicsClock>(offset_s, 40.0, runtime.now_ns());
  open();
  refresh(5);
  const auto displayed = headset->facts().display.displayed;
  EXPECT_EQ(settings.clock.to_monotonic(displayed), runtime.counts().display_ns);
  EXPECT_TRUE(headset->head_at(settings.clock.from_monotonic(runtime.now_ns())).usable());
  EXPECT_FALSE(headset->head_at(now()).usable()) << "that is another clock's";
}

TEST_F(HeadsetPace, WaitsWhileNobodyWearsIt) {
  runtime.wear(false);
  open();
  EXPECT_FALSE(runtime.refresh(0.05)) << "no frame is asked for";
  EXPECT_EQ(headset->facts().state, HeadsetState::waiting);
  EXPECT_FALSE(headset->trouble(now()));
  runtime.wear(true);
  EXPECT_TRUE(runtime.refresh());
  EXPECT_EQ(headset->facts().state, HeadsetState::showing);
  runtime.wear(false);
  EXPECT_TRUE(comes_to_be([this] { return headset->facts().state == HeadsetState::waiting; }));
  runtime.wear(true);
  EXPECT_TRUE(runtime.refresh());
}

TEST_F(HeadsetPace, RefusesAPictureOfAnotherSize) {
  open();
  const std::vector<std::uint8_t> rgb(640 * 480 * 3);
  EXPECT_THROW(headset->show({rgb, 480, 640, now(), 0.6}), std::invalid_argument);
  EXPECT_THROW(headset->show({rgb, 640, 480, now(), 0.0}), std::invalid_argument);
  EXPECT_THROW(headset->show({std::span(rgb).first(9), 640, 480, now(), 0.6}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::headset
