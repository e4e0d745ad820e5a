#include "tools/demo/snapshot_selector.h"

#include <gtest/gtest.h>

#include <set>

#include "applications/pingpong/pingpong.h"
#include "applications/touch/touch.h"
#include "tests/scratch_folder.h"

namespace palpate::tools::demo {
namespace {

device::CameraModel lens() {
  device::CameraModel model;
  model.width = 64, model.height = 48;
  model.fx = model.fy = 56.0, model.cx = 32.0, model.cy = 24.0;
  return model;
}

// The camera looks along +z from the origin; the bat faces it half a metre away.
server::graphics::FrameRecord frame(double s, const Vector3& ball, int hits = 0) {
  server::graphics::FrameRecord f;
  f.have_state = true;
  f.state.time = Instant<PhysicsClock>{seconds(s)};
  f.state.body_count = 2;
  f.state.bodies[applications::pingpong::kBall].set_p(ball);
  f.state.bodies[applications::pingpong::kBat].set_p({0.0, 0.0, 0.5});
  f.state.bodies[applications::pingpong::kBat].set_q(rotation_between(Vector3::UnitY(), Vector3::UnitZ()));
  f.state.counters[applications::pingpong::kHits] = hits;
  f.width = 64, f.height = 48;
  f.rgb.assign(64 * 48 * 3, 100);
  return f;
}
const Vector3 kBehindBat(0.0, 0.05, 0.8), kBeside(0.2, 0.0, 0.8), kInFront(0.0, 0.05, 0.4);

TEST(BallInSight, HiddenOnlyBehindTheBatOrOutOfThePicture) {
  const scene::SceneDescription scene;
  EXPECT_FALSE(ball_in_sight(frame(0, kBehindBat), lens(), scene));
  EXPECT_TRUE(ball_in_sight(frame(0, kBeside), lens(), scene));
  EXPECT_TRUE(ball_in_sight(frame(0, kInFront), lens(), scene));
  EXPECT_FALSE(ball_in_sight(frame(0, {2.0, 0.0, 0.8}), lens(), scene));
  EXPECT_FALSE(ball_in_sight(frame(0, {0.0, 0.0, -0.8}), lens(), scene));
  auto nothing = frame(0, kBeside);
  nothing.have_state = false;
  EXPECT_FALSE(ball_in_sight(nothing, lens(), scene));
}

TEST(BallInSight, RimOfTheBatIsWhereTheLineOfSightGrazesIt) {
  scene::SceneDescription scene;
  scene.bat_radius = 0.1;  // at 0.5 m; a ball at 1 m is hidden up to 0.2 m aside
  EXPECT_FALSE(ball_in_sight(frame(0, {0.199, 0.0, 1.0}), lens(), scene));
  EXPECT_TRUE(ball_in_sight(frame(0, {0.201, 0.0, 1.0}), lens(), scene));
}

TEST(SnapshotSelector, WaitsForTheBallAndThenTakesWhatThereIs) {
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 5.0, lens(), {});
  // The first moment comes after a quarter of a second, unseen until 0.5 s; the second never sees the ball.
  for (int i = 0; i < 180; ++i) {
    const double t = i / 100.0;
    ASSERT_TRUE(book.look(frame(t, t >= 0.5 && t < 1.0 ? kBeside : kBehindBat)));
    EXPECT_EQ(book.captions().size(), t < 0.5 ? 0u : t < 1.75 ? 1u : 2u) << t;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "01-play.png"));
}

TEST(SnapshotSelector, AHitIsShownWhenTheBallComesOutBehindTheBatSoonEnough) {
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 1000.0, lens(), {});
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const double t = i / 100.0, since = t - std::floor(t);
    hits =
        static_cast<int>(t);  // one each second; the ball is seen 0.1 s later, but after the second hit 0.4 s
    const bool seen = hits > 0 && since > (hits == 2 ? 0.4 : 0.1);
    ASSERT_TRUE(book.look(frame(t, seen ? kBeside : kBehindBat, hits)));
  }
  EXPECT_EQ(book.captions().size(), 3u);
  EXPECT_TRUE(book.captions().contains("03-hit.png"));
}

TEST(SnapshotSelector, SaysWhatEachPictureShowsAndWhen) {
  using applications::pingpong::Phase;
  const scene::SceneDescription scene;
  const auto seen = [&](Phase phase, int serves, int rally, bool hit, bool sight) {
    auto f = frame(3.0, kBeside);
    f.state.counters[applications::pingpong::kPhase] = static_cast<std::int32_t>(phase);
    f.state.counters[applications::pingpong::kServes] = serves;
    f.state.counters[applications::pingpong::kRally] = rally;
    return what_is_seen(f, scene, hit, sight);
  };
  EXPECT_EQ(seen(Phase::ready, 1, 0, false, true), "ball 2 waits to be served");
  EXPECT_EQ(seen(Phase::incoming, 2, 0, false, true), "serve 2 on its way to the player");
  EXPECT_EQ(seen(Phase::incoming, 2, 3, false, true), "the ball comes back from the wall");
  EXPECT_EQ(seen(Phase::outgoing, 2, 3, false, true), "the ball on its way to the wall");
  EXPECT_EQ(seen(Phase::outgoing, 2, 3, false, false),
            "the ball on its way to the wall, hidden by the bat or out of the picture");
  EXPECT_EQ(seen(Phase::outgoing, 2, 3, true, true), "the bat has just met the ball");
  EXPECT_EQ(seen(Phase::waiting, 2, 3, false, false), "between two balls");
  scene::SceneDescription touched;
  touched.application = "touch";
  auto f = frame(1.0, kBeside);
  EXPECT_EQ(what_is_seen(f, touched, false, true), "the tip above the surface");
  f.state.counters[applications::touch::kForceMn] = 900;
  EXPECT_EQ(what_is_seen(f, touched, false, true), "the tip holds on the surface");
  f.state.counters[applications::touch::kSliding] = 1;
  EXPECT_EQ(what_is_seen(f, touched, false, true), "the tip slides over the surface");
  EXPECT_EQ(what_is_seen(f, touched, true, true), "the tip has just met the surface");
  // Two pictures never bear the same words: the moment is among them.
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 5.0, lens(), scene);
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(book.look(frame(2.0 + i / 100.0, kBeside)));
  std::set<std::string> captions;
  for (const auto& caption : book.captions()) captions.insert(caption.get<std::string>());
  EXPECT_GE(book.captions().size(), 4u);
  EXPECT_EQ(captions.size(), book.captions().size());
  EXPECT_EQ(book.captions()["01-play.png"], "Between two balls, 0.2 s into the play");
}

TEST(SnapshotSelector, SaysFromTheSideWhoseEyesArePyramids) {
  const ScratchFolder folder;
  for (const bool two : {false, true}) {
    SnapshotSelector book(folder.path(), 4.0, lens(), {});
    render::OutsidePicture outside{0, 2, 1, {1, 2, 3, 4, 5, 6}};
    book.look_from_outside(
        [&](const server::graphics::FrameRecord&) -> const render::OutsidePicture& { return outside; });
    for (int i = 1; i < 100; ++i) {
      auto f = frame(i / 100.0, kBeside);
      f.two_eyes = two;
      ASSERT_TRUE(book.look(f));
    }
    const std::string caption = book.captions()["outside.png"];
    EXPECT_NE(caption.find(two ? "pyramids are what the player's two cameras see"
                               : "pyramid is what the player's camera sees"),
              std::string::npos)
        << caption;
  }
}

TEST(SnapshotSelector, ShowsTheFirstHitFromTheSideOrElseTheFirstMoment) {
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 4.0, lens(), {});
  std::vector<double> seen_at;
  render::OutsidePicture outside{0, 2, 1, {1, 2, 3, 4, 5, 6}};
  book.look_from_outside([&](const server::graphics::FrameRecord& frame) -> const render::OutsidePicture& {
    seen_at.push_back(frame.state.time.seconds());
    return outside;
  });
  for (int i = 1; i < 400; ++i) ASSERT_TRUE(book.look(frame(i / 100.0, kBeside, i / 150)));
  // The first moment is a quarter of the way to the second; hits come at 1.5 s and 3 s.
  ASSERT_EQ(seen_at.size(), 2u);
  EXPECT_NEAR(seen_at[0], 0.2, 0.011);
  EXPECT_NEAR(seen_at[1], 1.5, 1e-9);
  EXPECT_TRUE(std::filesystem::exists(folder / "outside.png"));
  EXPECT_TRUE(book.captions().contains("outside.png"));
}

}  // namespace
}  // namespace palpate::tools::demo
