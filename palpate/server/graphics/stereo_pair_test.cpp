#include "palpate/server/graphics/stereo_pair.h"

#include <gtest/gtest.h>

namespace palpate::server::graphics {
namespace {

Instant<GraphicsClock> pair_ms(double ms) { return Instant<GraphicsClock>::from_seconds(1e-3 * ms); }

StereoPair::Timed timed_image(std::uint64_t frame, double arrived_ms, double taken_ms) {
  StereoPair::Timed timed;
  timed.image.frame = frame;
  timed.at = pair_ms(arrived_ms), timed.moment = seconds(1e-3 * taken_ms);
  return timed;
}

TEST(StereoPair, ALeftImageWaitsForTheRightOneOfItsMoment) {
  StereoPair pair;
  EXPECT_FALSE(pair.take(pair_ms(0)));
  pair.left(timed_image(7, 40, 0));
  EXPECT_FALSE(pair.take(pair_ms(41)));
  pair.right(timed_image(21, 43, 0.9));  // cameras count for themselves
  const auto both = pair.take(pair_ms(43));
  ASSERT_TRUE(both && both->right);
  EXPECT_EQ(both->left.image.frame, 7u);
  EXPECT_EQ(both->right->frame, 21u);
  EXPECT_FALSE(pair.take(pair_ms(44)));  // once
}

TEST(StereoPair, TheRightImageMayComeFirst) {
  StereoPair pair;
  pair.right(timed_image(1, 39, 0));
  EXPECT_FALSE(pair.take(pair_ms(39)));
  pair.left(timed_image(1, 42, 0));
  const auto both = pair.take(pair_ms(42));
  ASSERT_TRUE(both && both->right);
}

TEST(StereoPair, WhereEitherLostItsImageNeitherIsShown) {
  StereoPair pair;
  pair.left(timed_image(1, 40, 0));
  EXPECT_FALSE(pair.take(pair_ms(40)));
  pair.right(timed_image(2, 73, 33));  // the first of the right was lost
  EXPECT_FALSE(pair.take(pair_ms(73)));
  EXPECT_EQ(pair.unpaired(), 1u);
  pair.left(timed_image(2, 74, 33));
  const auto both = pair.take(pair_ms(74));
  ASSERT_TRUE(both && both->right);
  EXPECT_EQ(both->left.image.frame, both->right->frame);
  pair.right(timed_image(3, 106, 66));
  EXPECT_FALSE(pair.take(pair_ms(106)));  // the third of the left was lost
  pair.right(timed_image(4, 140, 100));
  pair.left(timed_image(4, 140, 100));
  const auto later = pair.take(pair_ms(140));
  ASSERT_TRUE(later && later->right);
  EXPECT_EQ(later->right->frame, 4u);
}

TEST(StereoPair, ASilentRightCameraDoesNotHoldUpTheLeftOne) {
  StereoPair pair;
  EXPECT_FALSE(pair.take(pair_ms(0)));
  double first_alone_ms = 0.0;
  int alone = 0;
  for (int frame = 1; frame <= 30; ++frame) {
    const double arrival = 33.3 * frame + 40;
    if (frame <= 3) pair.right(timed_image(static_cast<std::uint64_t>(frame), arrival, arrival - 40));
    pair.left(timed_image(static_cast<std::uint64_t>(frame), arrival, arrival - 40));
    const auto images = pair.take(pair_ms(arrival));
    if (!images) continue;
    EXPECT_EQ(images->right.has_value(), frame <= 3);
    if (!images->right && alone++ == 0) first_alone_ms = arrival - (33.3 * 3 + 40);
  }
  EXPECT_TRUE(pair.right_lost());
  EXPECT_GT(first_alone_ms, 250.0);
  EXPECT_LE(first_alone_ms, 250.0 + 34.0);
  EXPECT_GT(alone, 15);
  // And back.
  pair.right(timed_image(31, 1100, 1060));
  pair.left(timed_image(31, 1100, 1060));
  const auto both = pair.take(pair_ms(1100));
  ASSERT_TRUE(both && both->right);
  EXPECT_FALSE(pair.right_lost());
}

TEST(StereoPair, CamerasThatExposeApartAreNotPaired) {
  StereoPair pair;
  int alone = 0;
  const auto look = [&](double ms) {
    if (const auto images = pair.take(pair_ms(ms))) {
      EXPECT_FALSE(images->right);
      ++alone;
    }
  };
  for (int frame = 0; frame < 60; ++frame) {
    const auto number = static_cast<std::uint64_t>(frame);
    pair.left(timed_image(number, 33.3 * frame + 40, 33.3 * frame));
    look(33.3 * frame + 40);
    pair.right(timed_image(number, 33.3 * frame + 57, 33.3 * frame + 16.5));
    look(33.3 * frame + 57);
  }
  EXPECT_GT(alone, 45);
  EXPECT_TRUE(pair.right_lost());
}

TEST(StereoPair, ARightCameraThatIsBackIsWaitedForAgainThoughItsImagesComeLast) {
  StereoPair pair;
  EXPECT_FALSE(pair.take(pair_ms(0)));
  for (int frame = 17; frame < 20; ++frame)
    pair.left(timed_image(static_cast<std::uint64_t>(frame), 33.3 * frame + 40, 33.3 * frame));
  pair.left(timed_image(20, 700, 660));
  const auto lone = pair.take(pair_ms(700));
  ASSERT_TRUE(lone && !lone->right);
  pair.right(timed_image(20, 705, 660));
  EXPECT_FALSE(pair.take(pair_ms(705)));
  pair.left(timed_image(21, 733, 693));
  EXPECT_FALSE(pair.take(pair_ms(733)));
  pair.right(timed_image(21, 738, 693));
  const auto both = pair.take(pair_ms(738));
  ASSERT_TRUE(both && both->right);
}

TEST(StereoPair, ASlowCameraThatLosesAnImageIsNotGivenUp) {
  StereoPair pair;
  for (int frame = 0; frame < 40; ++frame) {
    const auto number = static_cast<std::uint64_t>(frame);
    pair.left(timed_image(number, 200 * frame + 40, 200 * frame));
    if (frame % 3 != 0) pair.right(timed_image(number, 200 * frame + 40, 200 * frame));
    const auto images = pair.take(pair_ms(200 * frame + 40));
    EXPECT_EQ(images.has_value(), frame % 3 != 0);
    EXPECT_FALSE(pair.right_lost());
  }
}

TEST(StereoPair, ManyRightImagesWithoutALeftOneAreForgottenButTheNewest) {
  StereoPair pair;
  for (int frame = 0; frame < 1000; ++frame)
    pair.right(timed_image(static_cast<std::uint64_t>(frame), 33 * frame, 33 * frame));
  pair.left(timed_image(1, 33 * 999, 33 * 999));
  const auto both = pair.take(pair_ms(33 * 999));
  ASSERT_TRUE(both && both->right);
  EXPECT_EQ(both->right->frame, 999u);
}

}  // namespace
}  // namespace palpate::server::graphics
