#include "palpate/headset/head_history.h"

#include <gtest/gtest.h>

#include <numbers>

#include "palpate/headset/display_times.h"

namespace palpate::headset {
namespace {

using std::chrono::milliseconds;

Instant<GraphicsClock> at_ms(double ms) { return Instant<GraphicsClock>::from_seconds(1e-3 * ms); }

// A head that turns about an axis of the room through a point beside it.
Pose<Local, View> turning(double t) {
  const Vector3 rate = Vector3(0.2, 1.0, -0.3).normalized() * 50.0 * std::numbers::pi / 180.0;
  return {so3_exp(t * rate), Vector3(0.1, 1.6, 0.2) + t * Vector3(0.3, -0.1, 0.05)};
}

TEST(HeadHistory, KnowsASteadyTurnBetweenItsEntriesAndAMomentBeyond) {
  HeadHistory history;
  for (int i = 0; i < 60; ++i) {
    const double t = i / 90.0;
    ASSERT_TRUE(history.add(Instant<GraphicsClock>::from_seconds(t), turning(t)));
  }
  // A straight shift and a steady turn are what is carried on: exact but for rounding of times to 1 ns.
  for (const double t : {0.0, 0.1234, 0.4001, 0.6, 0.7}) {
    const auto head = history.at(Instant<GraphicsClock>::from_seconds(t));
    ASSERT_TRUE(head.usable()) << t;
    EXPECT_LT(angle_between(head.X_local_view.rotation, turning(t).rotation), 1e-7) << t;
    EXPECT_LT((head.X_local_view.translation - turning(t).translation).norm(), 1e-7) << t;
  }
}

TEST(HeadHistory, SaysWhatItDoesNotKnow) {
  HeadHistory history;
  EXPECT_FALSE(history.at(at_ms(5)).usable()) << "nothing has been added";
  history.add(at_ms(100), turning(0.1));
  history.add(at_ms(111), turning(0.111));
  EXPECT_FALSE(history.add(at_ms(111), turning(0.111))) << "not later";
  EXPECT_EQ(history.count(), 2U);
  EXPECT_EQ(history.at(at_ms(99)).kind, AnswerKind::too_old);
  EXPECT_EQ(history.at(at_ms(211)).kind, AnswerKind::extrapolated);
  EXPECT_EQ(history.at(at_ms(212)).kind, AnswerKind::too_new);
}

TEST(HeadHistory, RemembersFarMoreThanTheSpecificationPromises) {
  HeadHistory history;
  for (int i = 0; i < 2000; ++i) {
    const double t = i / 90.0;
    history.add(Instant<GraphicsClock>::from_seconds(t), turning(t));
  }
  EXPECT_TRUE(history.at(Instant<GraphicsClock>::from_seconds(1999 / 90.0 - 5.0)).usable());
}

TEST(DisplayTimes, AreThoseOfTheFirstFrameThatBeginsAfterwards) {
  const DisplayTimes times{at_ms(1000), at_ms(1022), milliseconds(11)};
  EXPECT_EQ(times.of_picture(at_ms(990)), at_ms(1022)) << "the newest frame had it";
  EXPECT_EQ(times.of_picture(at_ms(1000)), at_ms(1022));
  EXPECT_EQ(times.of_picture(at_ms(1000.5)), at_ms(1033));
  EXPECT_EQ(times.of_picture(at_ms(1011)), at_ms(1033));
  EXPECT_EQ(times.of_picture(at_ms(1011.1)), at_ms(1044));
  EXPECT_EQ(DisplayTimes{}.of_picture(at_ms(7)), at_ms(7)) << "nothing is known";
}

}  // namespace
}  // namespace palpate::headset
