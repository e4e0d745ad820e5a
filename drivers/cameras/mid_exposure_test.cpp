#include "drivers/cameras/mid_exposure.h"

#include <gtest/gtest.h>

#include "drivers/cameras/internal/frame_count.h"

namespace palpate::drivers::cameras {
namespace {

// By going through the rows of a sensor: when is the middle of the middle row's exposure, and what would each
// kind of stamp read?
TEST(MidExposure, IsTheMiddleRowsFromEveryKindOfStamp) {
  const std::int64_t start = 1'000'000, exposure = 4'000, readout = 9'000;
  for (const bool rolling : {false, true}) {
    const std::int64_t middle_row_begins = start + (rolling ? readout / 2 : 0);
    const std::int64_t middle = middle_row_begins + exposure / 2;
    const std::int64_t complete = start + exposure + readout;  // the last row has been read out
    const Shutter shutter{Duration(exposure), Duration(readout), rolling};
    EXPECT_EQ(start + to_mid_exposure(StampAt::exposure_start, shutter).count(), middle);
    EXPECT_EQ(start + exposure + to_mid_exposure(StampAt::exposure_end, shutter).count(), middle);
    EXPECT_EQ(complete + to_mid_exposure(StampAt::frame_end, shutter).count(), middle);
    EXPECT_EQ(middle + to_mid_exposure(StampAt::middle, shutter).count(), middle);
  }
}

TEST(FrameCount, GoesOnWhereTheCamerasCounterBeginsAnew) {
  FrameCount gige(1, 0xFFFF);
  EXPECT_EQ(gige.count(65534), 1u);
  EXPECT_EQ(gige.count(65535), 2u);
  EXPECT_EQ(gige.count(1), 3u);  // 0 is never sent
  EXPECT_EQ(gige.count(4), 6u);  // two lost
  gige.restart();                // another camera, or the same after a power cut
  EXPECT_EQ(gige.count(40000), 7u);
  FrameCount video(0, 0xFFFFFFFFu);
  EXPECT_EQ(video.count(0xFFFFFFFFu), 1u);
  EXPECT_EQ(video.count(0), 2u);
}

}  // namespace
}  // namespace palpate::drivers::cameras
