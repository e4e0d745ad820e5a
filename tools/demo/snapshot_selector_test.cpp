#include "tools/demo/snapshot_selector.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/scratch_folder.h"
#include "tools/demo/swing_for_tests.h"

namespace palpate::tools::demo {
namespace {

device::CameraModel lens() {
  device::CameraModel model;
  model.width = 64, model.height = 48;
  model.fx = model.fy = 56.0, model.cx = 32.0, model.cy = 24.0;
  return model;
}
const Vector3 kHidden(0.0, 0.0, -0.8), kInView(0.2, 0.0, 0.8);

// The camera looks along +z from the origin.
server::graphics::FrameRecord frame(double s, const Vector3& weight, int passes = 0) {
  server::graphics::FrameRecord f;
  f.have_state = true;
  f.state.time = Instant<PhysicsClock>{seconds(s)};
  f.state.body_count = 2;
  f.state.bodies[0].set_p(weight);
  f.state.counters[0] = passes;
  f.width = 64, f.height = 48;
  f.rgb.assign(64 * 48 * 3, 100);
  return f;
}
const SwingRecord kRecord;

TEST(SnapshotSelector, WaitsForASightOfItAndThenTakesWhatThereIs) {
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 5.0, lens(), kRecord);
  // The first moment comes after a quarter of a second, unseen until 0.5 s; the second never sees the weight.
  for (int i = 0; i < 180; ++i) {
    const double t = i / 100.0;
    ASSERT_TRUE(book.look(frame(t, t >= 0.5 && t < 1.0 ? kInView : kHidden)));
    EXPECT_EQ(book.captions().size(), t < 0.5 ? 0u : t < 1.75 ? 1u : 2u) << t;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "01-play.png"));
}

TEST(SnapshotSelector, AnEventIsShownWhenThereIsASightOfItSoonEnough) {
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 1000.0, lens(), kRecord);
  int passes = 0;
  for (int i = 0; i < 500; ++i) {
    const double t = i / 100.0, since = t - std::floor(t);
    passes =
        static_cast<int>(t);  // one each second; the weight is seen 0.1 s later, but after the second 0.4 s
    const bool seen = passes > 0 && since > (passes == 2 ? 0.4 : 0.1);
    ASSERT_TRUE(book.look(frame(t, seen ? kInView : kHidden, passes)));
  }
  EXPECT_EQ(book.captions().size(), 3u);
  EXPECT_TRUE(book.captions().contains("03-pass.png"));
}

// Two pictures never bear the same words: the moment is among them.
TEST(SnapshotSelector, SaysWhatEachPictureShowsAndWhen) {
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 5.0, lens(), kRecord);
  for (int i = 0; i < 500; ++i)
    ASSERT_TRUE(book.look(frame(2.0 + i / 100.0, i < 200 ? kInView : kHidden, i < 100 ? 0 : 1)));
  std::set<std::string> captions;
  for (const auto& caption : book.captions()) captions.insert(caption.get<std::string>());
  EXPECT_GE(book.captions().size(), 5u);
  EXPECT_EQ(captions.size(), book.captions().size());
  EXPECT_EQ(book.captions()["01-play.png"], "The weight swings, 0.2 s into the play");
  EXPECT_EQ(book.captions()["02-pass.png"], "The weight has just passed, 1.0 s into the play");
  EXPECT_EQ(book.captions()["04-play.png"], "The weight swings elsewhere, 2.8 s into the play");
}

TEST(SnapshotSelector, SaysFromTheSideWhoseEyesArePyramids) {
  const ScratchFolder folder;
  for (const bool two : {false, true}) {
    SnapshotSelector book(folder.path(), 4.0, lens(), kRecord);
    render::OutsidePicture outside{0, 2, 1, {1, 2, 3, 4, 5, 6}};
    book.look_from_outside(
        [&](const server::graphics::FrameRecord&) -> const render::OutsidePicture& { return outside; });
    for (int i = 1; i < 100; ++i) {
      auto f = frame(i / 100.0, kInView);
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

TEST(SnapshotSelector, ShowsTheFirstEventFromTheSideOrElseTheFirstMoment) {
  const ScratchFolder folder;
  SnapshotSelector book(folder.path(), 4.0, lens(), kRecord);
  std::vector<double> seen_at;
  render::OutsidePicture outside{0, 2, 1, {1, 2, 3, 4, 5, 6}};
  book.look_from_outside([&](const server::graphics::FrameRecord& frame) -> const render::OutsidePicture& {
    seen_at.push_back(frame.state.time.seconds());
    return outside;
  });
  for (int i = 1; i < 400; ++i) ASSERT_TRUE(book.look(frame(i / 100.0, kInView, i / 150)));
  // The first moment is a quarter of the way to the second; passes come at 1.5 s and 3 s.
  ASSERT_EQ(seen_at.size(), 2u);
  EXPECT_NEAR(seen_at[0], 0.2, 0.011);
  EXPECT_NEAR(seen_at[1], 1.5, 1e-9);
  EXPECT_TRUE(std::filesystem::exists(folder / "outside.png"));
  EXPECT_TRUE(book.captions().contains("outside.png"));
}

}  // namespace
}  // namespace palpate::tools::demo
