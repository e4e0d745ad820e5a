#include "palpate/scene/play_record.h"

#include <gtest/gtest.h>

namespace palpate::scene {
namespace {

// Looks along +z from the origin; 64 x 48 pixels, which at a distance of 1 m are 1.14 m x 0.86 m.
device::CameraModel lens() {
  return {.width = 64, .height = 48, .fx = 56.0, .fy = 56.0, .cx = 32.0, .cy = 24.0};
}

TEST(ShownPicture, ShowsWhatLiesBeforeTheCameraAndWithinTheFrame) {
  const SceneState state;
  const auto model = lens();
  const ShownPicture picture{.state = state, .have_state = true, .lens = model, .X_world_camera = {}};
  EXPECT_TRUE(picture.shows({0.0, 0.0, 1.0}));
  EXPECT_TRUE(picture.shows({0.57, 0.0, 1.0}));
  EXPECT_FALSE(picture.shows({0.58, 0.0, 1.0}));
  EXPECT_TRUE(picture.shows({0.0, -0.42, 1.0}));
  EXPECT_FALSE(picture.shows({0.0, -0.43, 1.0}));
  EXPECT_FALSE(picture.shows({0.0, 0.0, -1.0}));
  EXPECT_FALSE(picture.shows({0.0, 0.0, 0.0}));
  // A camera that stands elsewhere and looks the other way.
  const ShownPicture turned{.state = state,
                            .have_state = true,
                            .lens = model,
                            .X_world_camera = {Quaternion(0, 0, 1, 0), {0.0, 0.0, 3.0}}};
  EXPECT_TRUE(turned.shows({0.0, 0.0, 1.0}));
  EXPECT_FALSE(turned.shows({0.0, 0.0, 4.0}));
}

TEST(PlayRecord, WithoutOneOfItsOwnAnApplicationsFirstBodyIsWhatIsLookedFor) {
  const PlayRecord record;
  const auto model = lens();
  SceneState state;
  state.body_count = 1;
  state.bodies[0].set_p({0.1, 0.0, 1.0});
  const auto seen = [&](bool have_state) {
    return record.highlight({.state = state, .have_state = have_state, .lens = model, .X_world_camera = {}});
  };
  EXPECT_TRUE(seen(true).in_sight);
  EXPECT_FALSE(seen(false).in_sight);
  EXPECT_EQ(seen(true).events, 0);
  EXPECT_EQ(seen(true).going_on, "the play goes on");
  EXPECT_EQ(seen(true).unseen, "the play goes on, out of the picture");
  state.bodies[0].visible = 0;
  EXPECT_FALSE(seen(true).in_sight);
  state.bodies[0].visible = 1;
  state.bodies[0].set_p({5.0, 0.0, 1.0});
  EXPECT_FALSE(seen(true).in_sight);
}

}  // namespace
}  // namespace palpate::scene
