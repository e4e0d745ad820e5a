#include "palpate/server/graphics/quality_choice.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace palpate::server::graphics {
namespace {

using render::Quality;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr Duration kInterval = microseconds(33'333);

// A frame loop beside a camera: drawing at each level takes so long, and what came meanwhile is missed but for the newest.
class Loop {
 public:
  Loop(Quality first, std::vector<Duration> costs) : choice(first), costs_(std::move(costs)) {}
  void run(Duration length) {
    for (const auto end = now_ + length; now_ < end;) {
      const bool longer = choice.quality() == now_and_then_ && ++drawn_ % 8 == 0;
      const Duration busy = longer ? longer_ : costs_[static_cast<std::size_t>(choice.quality())];
      now_ = std::max(now_ + busy, at(image_ + 1));
      while (at(image_ + 1) <= now_) ++image_;
      if (const auto words = choice.frame(now_, busy, image_, Instant<CameraClock>{at(image_).since_epoch}))
        said.push_back(*words);
    }
  }
  void lose_images(std::uint64_t count) { image_ += count, now_ = at(image_); }
  void set_cost(Quality quality, Duration cost) { costs_[static_cast<std::size_t>(quality)] = cost; }
  void set_now_and_then(Quality quality, Duration cost) { now_and_then_ = quality, longer_ = cost; }
  QualityChoice choice;
  std::vector<std::string> said;

 private:
  static Instant<GraphicsClock> at(std::uint64_t image) {
    return Instant<GraphicsClock>{static_cast<Duration::rep>(image) * kInterval};
  }
  std::vector<Duration> costs_;
  std::optional<Quality> now_and_then_;  // one picture in eight takes `longer_`
  Duration longer_{};
  int drawn_ = 0;
  Instant<GraphicsClock> now_;
  std::uint64_t image_ = 0;
};

TEST(QualityChoice, GivesWayWhereImagesAreMissed) {
  Loop loop(Quality::medium, {milliseconds(10), milliseconds(40), milliseconds(80)});
  loop.run(std::chrono::seconds(3));
  EXPECT_EQ(loop.choice.quality(), Quality::low);
  ASSERT_EQ(loop.said.size(), 1u);
  EXPECT_NE(loop.said[0].find("quality low"), std::string::npos) << loop.said[0];
  EXPECT_NE(loop.said[0].find("were missed"), std::string::npos) << loop.said[0];
}

TEST(QualityChoice, FallsStepByStepAsFarAsItMust) {
  Loop loop(Quality::high, {milliseconds(10), milliseconds(40), milliseconds(80)});
  loop.run(std::chrono::seconds(10));
  EXPECT_EQ(loop.choice.quality(), Quality::low);
  EXPECT_EQ(loop.said.size(), 2u);
}

TEST(QualityChoice, TriesMoreWhereThereIsTime) {
  Loop loop(Quality::low, {milliseconds(2), milliseconds(4), milliseconds(20)});
  loop.run(std::chrono::seconds(30));
  EXPECT_EQ(loop.choice.quality(), Quality::high);
  EXPECT_EQ(loop.said.size(), 2u);
  EXPECT_NE(loop.said[0].find("time to spare"), std::string::npos) << loop.said[0];
}

TEST(QualityChoice, RemembersHowDearALevelWas) {
  Loop loop(Quality::low, {milliseconds(4), milliseconds(40), milliseconds(80)});
  loop.run(std::chrono::minutes(10));
  EXPECT_EQ(loop.choice.changes(), 2u);  // ten times as dear does not fit
  EXPECT_EQ(loop.choice.quality(), Quality::low);
  loop.set_cost(Quality::low, milliseconds(2));
  loop.set_cost(Quality::medium, milliseconds(20));
  loop.run(std::chrono::minutes(1));
  EXPECT_EQ(loop.choice.quality(), Quality::medium);
}

TEST(QualityChoice, TriesWhatItMissedAgainEverMoreSeldom) {
  Loop loop(Quality::low, {milliseconds(2), milliseconds(20), milliseconds(80)});
  loop.set_now_and_then(Quality::medium, milliseconds(70));  // most pictures would fit
  loop.run(std::chrono::minutes(10));
  // After 20, 40, 80, 160 and 320 s at the earliest: up and down again each time.
  EXPECT_GE(loop.choice.changes(), 8u);
  EXPECT_LE(loop.choice.changes(), 12u);
  EXPECT_EQ(loop.choice.quality(), Quality::low);
}

TEST(QualityChoice, StaysWhereTheDearerLevelWouldNotFit) {
  Loop loop(Quality::low, {milliseconds(14), milliseconds(30), milliseconds(60)});
  loop.run(std::chrono::minutes(2));
  EXPECT_EQ(loop.choice.changes(), 0u);
}

TEST(QualityChoice, BelowLowThereIsNothing) {
  Loop loop(Quality::low, {milliseconds(100), milliseconds(200), milliseconds(300)});
  loop.run(std::chrono::minutes(1));
  EXPECT_EQ(loop.choice.changes(), 0u);
}

TEST(QualityChoice, ImagesThatAnIdleLoopMissedAreTheCameras) {
  Loop loop(Quality::medium, {milliseconds(2), milliseconds(5), milliseconds(30)});
  for (int i = 0; i < 100; ++i) {
    loop.run(milliseconds(150));
    loop.lose_images(2);
  }
  EXPECT_EQ(loop.choice.quality(), Quality::medium);
}

TEST(QualityChoice, ACameraThatStoodStillOrBeganAnewSaysNothing) {
  Loop loop(Quality::medium, {milliseconds(5), milliseconds(20), milliseconds(30)});
  for (int i = 0; i < 20; ++i) {
    loop.run(std::chrono::seconds(1));
    loop.lose_images(40);
  }
  EXPECT_EQ(loop.choice.changes(), 0u);
  EXPECT_FALSE(loop.choice.frame({}, milliseconds(20), 3, {}));
}

TEST(QualityChoice, TheSameFramesGiveTheSameChoice) {
  std::vector<std::string> said[2];
  for (auto& words : said) {
    Loop loop(Quality::medium, {milliseconds(6), milliseconds(40), milliseconds(80)});
    loop.run(std::chrono::minutes(2));
    words = loop.said;
  }
  EXPECT_FALSE(said[0].empty());
  EXPECT_EQ(said[0], said[1]);
}

}  // namespace
}  // namespace palpate::server::graphics
