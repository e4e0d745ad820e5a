#include "palpate/sim/per_lens.h"

#include <gtest/gtest.h>

namespace palpate::sim {
namespace {

class PartsOfLenses : public ::testing::Test {
 protected:
  // The focal length a part was made for.
  double of(double focal_length) {
    return parts_.of({.fx = focal_length}, [this](const device::CameraModel& lens) {
      ++made_;
      return lens.fx;
    });
  }
  PerLens<double> parts_;
  int made_ = 0;
};

TEST_F(PartsOfLenses, AreMadeOnceForTwoCamerasThatTakeTurns) {
  for (int picture = 0; picture < 5; ++picture) {
    EXPECT_EQ(of(500.0), 500.0);
    EXPECT_EQ(of(510.0), 510.0);
    EXPECT_EQ(parts_.latest(), 510.0);
  }
  EXPECT_EQ(made_, 2);
}

TEST_F(PartsOfLenses, TheLensNotUsedLastMakesRoomForAnother) {
  of(500.0);
  of(510.0);
  of(500.0);
  EXPECT_EQ(of(520.0), 520.0);
  EXPECT_EQ(of(500.0), 500.0);
  EXPECT_EQ(made_, 3);
  EXPECT_EQ(of(510.0), 510.0);
  EXPECT_EQ(made_, 4);
}

}  // namespace
}  // namespace palpate::sim
