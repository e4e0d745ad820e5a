// Which things a frame shows, and when there is no picture at all.
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/math/looking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>

#include "palpate/vision/synthetic_charuco.h"

namespace palpate::server::graphics {
namespace {

constexpr int kFrameWidth = 320, kFrameHeight = 240;
constexpr std::uint8_t kLevel = 150;
const device::CameraModel kFrameLens{kFrameWidth, kFrameHeight, 300, 300, 159.5, 119.5, {}};
using Picture = std::vector<std::uint8_t>;

// A red ball at body 0's place, and a line of text.
class BallView : public scene::SceneView {
 public:
  std::vector<scene::DrawItem> draw(const scene::SceneState& state) const override {
    scene::DrawItem item;
    item.mesh = &ball_;
    item.look = {{0.6f, 0.02f, 0.02f}, 0.0f, 0.0f, 0.0f};
    item.position = state.bodies[0].p();
    return {item};
  }
  std::vector<std::string> captions(const scene::SceneState&) const override { return {"3 : 2"}; }

 private:
  scene::TriangleMesh ball_ = scene::sphere_mesh(0.03);
};

rig::SurfaceCalibration level_table() {
  rig::SurfaceCalibration table;
  table.name = "table";
  table.width = table.height = 1.0;
  table.X_world_rectangle.rotation = rotation_from_xyz({-std::numbers::pi / 2.0, 0.0, 0.0});
  return table;
}

rig::Rig rig_of(int cameras) {
  rig::Rig rig;
  rig.camera = rig::CameraCalibration{kFrameLens, {}};
  rig.hand_eye.emplace();
  rig.arm.emplace().model.name = rig::kMouseArm;  // without a body
  rig.surfaces = {level_table()};
  if (cameras == 1) return rig;
  rig.right_camera = rig.camera;
  rig.right_hand_eye.emplace().X_marker_camera.translation = Vector3(0.06, 0, 0);
  return rig;
}

scene::SceneDescription scene_on(const rig::Rig& rig) {
  scene::SceneDescription scene;
  for (const auto& surface : rig.surfaces)
    scene.surfaces.push_back(
        {surface.name, {surface.corner(0).m, surface.corner(1).m, surface.corner(2).m, surface.corner(3).m}});
  return scene;
}

device::CameraImage image_of(const std::vector<std::uint8_t>& grey) {
  device::CameraImage image;
  image.width = kFrameWidth, image.height = kFrameHeight;
  for (const auto level : grey) image.rgb.insert(image.rgb.end(), {level, level, level});
  return image;
}
const device::CameraImage kEven = image_of(Picture(kFrameWidth * kFrameHeight, kLevel));

// Over the table, looking down at its middle.
FrameRecord frame_at(const Vector3& ball, std::uint64_t number = 1) {
  FrameRecord record;
  record.number = number;
  record.X_world_camera = looking({0.5, 0.5, -0.1}, {0.5, 0.05, -0.5});
  record.have_state = true;
  record.state.tick = 1;
  record.state.bodies[0].position = {ball.x(), ball.y(), ball.z()};
  return record;
}
const Vector3 kBall(0.5, 0.05, -0.5);

bool red_at(const FrameRecord& record, double u, double v) {
  const auto* p = &record.rgb[static_cast<std::size_t>(3 * (std::lround(v) * record.width + std::lround(u)))];
  return p[0] > 2 * p[1] + 20;
}
// Its middle, in pixels of the whole picture.
double middle_of_red(const FrameRecord& record, int from, int to) {
  double sum = 0.0;
  int count = 0;
  for (int v = 0; v < record.height; ++v)
    for (int u = from; u < to; ++u)
      if (red_at(record, u, v)) sum += u, ++count;
  return count == 0 ? -1.0 : sum / count;
}

struct Renderer : FrameRenderer {
  explicit Renderer(const rig::Rig& rig) : FrameRenderer(rig, scene_on(rig), std::make_unique<BallView>()) {
    set_captions(false);
  }
};

TEST(FrameRenderer, DrawsWhatTheStateHasWhereItIsAndNothingBeforeThereIsAState) {
  Renderer renderer(rig_of(1));
  FrameRecord record = frame_at(kBall);
  record.have_state = false;
  renderer.draw(kEven, nullptr, record);
  EXPECT_TRUE(record.rgb.empty());
  EXPECT_TRUE(renderer.outside(record).rgb.empty());
  record.have_state = true;
  renderer.draw(kEven, nullptr, record);
  EXPECT_EQ(record.width, kFrameWidth);
  ASSERT_EQ(record.rgb.size(), 3u * kFrameWidth * kFrameHeight);
  const auto at = kFrameLens.project_undistorted((record.X_world_camera.inverse() * Point<World>{kBall}).m);
  EXPECT_TRUE(red_at(record, at.x(), at.y()));
  EXPECT_NEAR(middle_of_red(record, 0, kFrameWidth), at.x(), 0.5);
  EXPECT_NEAR(record.rgb[0], kLevel, 1) << "the image elsewhere";
}

TEST(FrameRenderer, OfAnotherSceneTheCamerasPictureIsAllThereIs) {
  Renderer renderer(rig_of(1));
  renderer.set_captions(true);
  FrameRecord record = frame_at(kBall, 1);
  renderer.draw(kEven, nullptr, record);
  const Picture before = renderer.outside(record).rgb;
  record.number = 2;
  record.other_scene = true;
  record.have_state = false;
  renderer.draw(kEven, nullptr, record);
  ASSERT_EQ(record.rgb.size(), kEven.rgb.size());
  for (std::size_t i = 0; i < record.rgb.size(); ++i) ASSERT_NEAR(record.rgb[i], kLevel, 1) << i;
  EXPECT_NE(renderer.outside(record).rgb, before) << "the ball is gone from there, too";
}

// A level's picture is the same however often it is left and taken up again, and stages are told at each.
TEST(FrameRenderer, DrawsWithTheQualityThatIsAskedFor) {
  Renderer changed(rig_of(1));
  std::vector<std::string> stages;
  changed.watch_stages([&](const char* stage) { stages.emplace_back(stage); });
  for (const auto quality :
       {render::Quality::low, render::Quality::medium, render::Quality::high, render::Quality::low}) {
    FrameRenderer fresh(rig_of(1), scene_on(rig_of(1)), std::make_unique<BallView>(), quality);
    fresh.set_captions(false);
    FrameRecord as_changed = frame_at(kBall), as_fresh = frame_at(kBall);
    stages.clear();
    changed.set_quality(quality);
    changed.draw(kEven, nullptr, as_changed);
    fresh.draw(kEven, nullptr, as_fresh);
    EXPECT_EQ(as_changed.rgb, as_fresh.rgb) << render::quality_word(quality);
    for (const char* stage : {"scene", "shadows", "layer", "captions"})
      EXPECT_EQ(std::count(stages.begin(), stages.end(), stage), 1) << stage;
  }
  FrameRecord low = frame_at(kBall), medium = frame_at(kBall);
  changed.draw(kEven, nullptr, low);
  changed.set_quality(render::Quality::medium);
  changed.draw(kEven, nullptr, medium);
  EXPECT_NE(low.rgb, medium.rgb);
}

// All that a picture goes through has been gone through, and it looks as without that.
TEST(FrameRenderer, ARehearsalDrawsEverythingAndLeavesNothing) {
  for (const int cameras : {1, 2}) {
    Renderer rehearsed(rig_of(cameras)), fresh(rig_of(cameras));
    std::vector<std::string> stages;
    rehearsed.watch_stages([&](const char* stage) { stages.emplace_back(stage); });
    rehearsed.rehearse();
    EXPECT_EQ(stages, (std::vector<std::string>{"scene", "shadows", "background", "upload", "layer", "over",
                                                "read", "captions"}));
    FrameRecord after = frame_at(kBall), alone = frame_at(kBall);
    rehearsed.draw(kEven, nullptr, after);
    fresh.draw(kEven, nullptr, alone);
    EXPECT_EQ(after.rgb, alone.rgb);
  }
}

TEST(FrameRenderer, CaptionsStandInThePictureUnlessSomebodyElseShowsThem) {
  Renderer renderer(rig_of(1));
  FrameRecord without = frame_at(kBall), with = frame_at(kBall);
  renderer.draw(kEven, nullptr, without);
  renderer.set_captions(true);
  renderer.draw(kEven, nullptr, with);
  std::size_t different = 0;
  for (std::size_t i = 0; i < with.rgb.size(); ++i) different += with.rgb[i] != without.rgb[i];
  EXPECT_GT(different, 30u);
  EXPECT_EQ(renderer.captions(with.state), (std::vector<std::string>{"3 : 2"}));
}

TEST(FrameRenderer, EachEyeHasItsOwnPictureAndBothTheLeftOnesWhileTheRightCameraIsSilent) {
  Renderer renderer(rig_of(2));
  FrameRecord both = frame_at(kBall);
  both.two_eyes = true;
  both.right.emplace().X_world_camera = rig::right_eye_pose(rig_of(2), both.X_world_camera);
  FrameRecord one = frame_at(kBall);
  one.two_eyes = true;
  renderer.draw(kEven, &kEven, both);
  renderer.draw(kEven, nullptr, one);
  for (const auto* record : {&both, &one}) {
    EXPECT_EQ(record->width, 2 * kFrameWidth);
    ASSERT_EQ(record->rgb.size(), 6u * kFrameWidth * kFrameHeight);
  }
  const auto disparity = [](const FrameRecord& record) {
    return middle_of_red(record, 0, kFrameWidth) + kFrameWidth -
           middle_of_red(record, kFrameWidth, 2 * kFrameWidth);
  };
  const double depth = (both.X_world_camera.inverse() * Point<World>{kBall}).m.z();
  EXPECT_NEAR(disparity(both), 300 * 0.06 / depth, 0.5);
  EXPECT_NEAR(disparity(one), 0.0, 1e-9);
}

TEST(FrameRenderer, FromOutsideAFrameIsDrawnOnce) {
  Renderer renderer(rig_of(1));
  const FrameRecord first = frame_at(kBall, 1);
  const Picture seen = renderer.outside(first).rgb;
  ASSERT_FALSE(seen.empty());
  FrameRecord moved = frame_at(kBall + Vector3(-0.2, 0.1, 0.0), 1);
  EXPECT_EQ(renderer.outside(moved).rgb, seen) << "of the same number";
  moved.number = 2;
  EXPECT_NE(renderer.outside(moved).rgb, seen);
  FrameRecord unknown = frame_at(kBall, 3);
  unknown.have_state = false;
  EXPECT_EQ(renderer.outside(unknown).frame, 2u) << "the last one that is known";
}

// On a desk, whose board says where the camera is.
struct DeskWithBoard {
  device::CharucoBoard board;
  rig::Rig rig = rig::desk_rig(board);
  DeskWithBoard() { rig.camera = rig::CameraCalibration{kFrameLens, {}}; }
  Pose<World, CameraOptical> truth() const {
    const Vector3 middle = (rig.board->X_world_board * Point<Board>{board.middle()}).m;
    return looking(middle + Vector3(0.05, 0.40, 0.25), middle);
  }
  device::CameraImage image(const device::CharucoBoard& seen) const {
    Random random(1, "frame renderer");
    return image_of(vision::synthetic::CharucoCamera(kFrameLens, seen, 2)
                        .grey(truth().inverse() * rig.board->X_world_board, 1.0, random));
  }
};

TEST(FrameRenderer, WithoutItsBoardNothingVirtualIsDrawnAfterThreeImagesUntilItIsBack) {
  const DeskWithBoard desk;
  Renderer renderer(desk.rig);
  const Vector3 ball =
      (desk.rig.board->X_world_board * Point<Board>{desk.board.middle()}).m + Vector3(0, 0.05, 0);
  const auto shows = [&](const device::CameraImage& image) {
    FrameRecord record = frame_at(ball);
    record.X_world_camera = desk.truth();
    const bool found = renderer.find(image, std::nullopt, record).has_value();
    EXPECT_EQ(record.landmarks_predicted, desk.board.corners());
    if (found) {
      EXPECT_LT((record.X_world_camera.translation - desk.truth().translation).norm(), 0.005);
      EXPECT_GT(record.landmarks_used, desk.board.corners() / 2);
    }
    renderer.draw(image, nullptr, record);
    return std::pair(found, middle_of_red(record, 0, kFrameWidth) > 0.0);
  };
  const auto there = desk.image(desk.board);
  EXPECT_EQ(shows(there), std::pair(true, true));
  EXPECT_EQ(shows(kEven), std::pair(false, true)) << "a glance aside";
  EXPECT_EQ(shows(kEven), std::pair(false, true));
  EXPECT_EQ(shows(kEven), std::pair(false, false)) << "where would it stand?";
  EXPECT_EQ(shows(kEven), std::pair(false, false));
  EXPECT_EQ(shows(there), std::pair(true, true));
  EXPECT_EQ(shows(kEven), std::pair(false, true)) << "counted anew";
}

TEST(FrameRenderer, AnotherBoardIsNamedByItsDictionary) {
  const DeskWithBoard desk;
  Renderer renderer(desk.rig);
  device::CharucoBoard other = desk.board;
  other.dictionary = "6x6_50";
  const auto image = desk.image(other);
  std::string why;
  for (int i = 0; i < 3; ++i) {
    FrameRecord record = frame_at(kBall);
    const auto found = renderer.find(image, std::nullopt, record);
    ASSERT_FALSE(found);
    why = found.error().message;
  }
  EXPECT_NE(why.find("6x6_50"), std::string::npos) << why;
  EXPECT_NE(why.find(desk.board.dictionary), std::string::npos) << why;
}

TEST(FrameRenderer, AMeshThatCannotBeReadIsWrongUse) {
  rig::Rig rig = rig_of(1);
  rig.objects.push_back({"head", "/nowhere/head.stl", 0.001, Quaternion::Identity(), Vector3::Zero()});
  EXPECT_THROW(Renderer{rig}, std::invalid_argument);
}

}  // namespace
}  // namespace palpate::server::graphics
