#include "palpate/device/marker_names.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

TEST(MarkerNames, MarkersHaveOneNameEach) {
  for (const auto marker : {MarkerId::tip_marker, MarkerId::camera_marker, MarkerId::pointer})
    EXPECT_EQ(marker_named(name_of_marker(marker)), marker);
  EXPECT_FALSE(marker_named("stylus"));
}

}  // namespace
}  // namespace palpate::device
