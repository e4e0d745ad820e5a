// Two eyes in a running game: each picture's virtual things stand still in that eye's real world, and the two
// agree. Played in lock-step.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "applications/pingpong/specification.h"
#include "palpate/evaluation/overlay_of_play.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/server/graphics/shown_frame.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"

namespace palpate::sim::lockstep {
namespace {

config::WorldFile two_eyed_world() {
  auto file = config::reference_world();
  file.camera.count = 2;
  file.camera.drop = 0.0;
  return file;
}

struct StereoPlay {
  rig::Rig rig;
  LockstepResult play;
  evaluation::OverlayOfPlay left, right;
  evaluation::DisparityErrors disparity;
  int width = 0;  // of the drawn pictures
  // From where the ball is seen in each half of a picture to where its place says, px.
  std::array<std::vector<double>, 2> ball_off;
};

// Middle of what is as orange as the ball in one half of a picture; nothing where little is.
std::optional<device::Pixel> ball_seen(const std::vector<std::uint8_t>& rgb, int eye) {
  device::Pixel sum = device::Pixel::Zero();
  int count = 0;
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const std::uint8_t* p = &rgb[static_cast<std::size_t>(3 * (1280 * v + 640 * eye + u))];
      if (p[0] < 200 || p[0] < p[1] + 60 || p[1] < p[2] + 30) continue;
      sum += device::Pixel(u, v);
      ++count;
    }
  if (count < 100) return std::nullopt;
  return sum / count;
}

StereoPlay play_with_two_eyes(const config::WorldFile& file, LockstepOptions options, double seconds_played,
                              bool drawn = false, const std::function<void(rig::Rig&)>& change = {}) {
  Simulator world(file, 4);
  StereoPlay s;
  s.rig = truth_rig(world);
  if (change) change(s.rig);
  const auto scene = server::physics::scene_from_rig(
      s.rig, *sim::config::scene_of(file, {applications::pingpong::specification()}, "pingpong"));
  options.applications = {applications::pingpong::specification()};
  options.seconds = seconds_played;
  options.seed = 4;
  LockstepPictures parts;
  std::optional<CameraRenderer> renderer;
  std::optional<server::graphics::FrameRenderer> pictures;
  if (drawn) {
    renderer.emplace();
    pictures.emplace(s.rig, scene, std::move(*options.applications.make_view(scene)), render::Quality::low);
    parts.camera = [&](const TrueView& view, std::vector<std::uint8_t>& rgb) { renderer->render(view, rgb); };
    parts.pipeline = &*pictures;
    parts.shown = [&](const server::graphics::FrameRecord& frame) {
      s.width = frame.width;
      ASSERT_EQ(frame.rgb.size(), 3u * 1280u * 480u);
      if (frame.state.bodies[0].visible == 0) return;
      const std::array<evaluation::CameraView, 2> views{
          {{s.rig.camera->model, frame.X_world_camera},
           {s.rig.right_camera->model, frame.right->X_world_camera}}};
      for (int eye = 0; eye < 2; ++eye) {
        const auto i = static_cast<std::size_t>(eye);
        const auto expected = evaluation::drawn_pixel(views[i], frame.state.bodies[0].p());
        const auto seen = ball_seen(frame.rgb, eye);
        if (expected && seen) s.ball_off[i].push_back((*seen - *expected).norm());
      }
    };
  }
  auto result = play_in_lockstep(world, s.rig, scene, options, parts, {});
  EXPECT_TRUE(result.has_value()) << result.error().message;
  s.play = std::move(*result);
  const auto points = evaluation::check_points(world.truth(), s.rig);
  s.left = evaluation::overlay_of_play(s.play.frames, s.rig.camera->model, points);
  s.right = evaluation::overlay_of_right_eye(s.play.frames, s.rig.right_camera->model, points);
  s.disparity = evaluation::disparity_of_play(s.play.frames, s.rig, points);
  return s;
}

TEST(StereoPlay, BothEyesPicturesStandStillAndTheDisparityOfVirtualThingsIsThatOfRealOnes) {
  const auto s = play_with_two_eyes(two_eyed_world(), {}, 1.0, true);
  ASSERT_GE(s.play.frames.size(), 29u);
  EXPECT_EQ(s.width, 1280);
  for (const auto& frame : s.play.frames) {
    ASSERT_TRUE(frame.record.right);
    EXPECT_EQ(frame.record.right->pose_source, server::graphics::PoseSource::refined);
    EXPECT_GE(frame.record.right->landmarks_used, 4);
  }
  EXPECT_LT(s.left.world.rms(), 0.2);
  EXPECT_LT(s.right.world.rms(), 0.2);
  EXPECT_LT(s.disparity.world.rms(), 0.1);
  // The right eye's picture is the right half, drawn from where the right eye is: the eyes are 30 px apart at
  // the ball. Its light side counts as orange, its shaded one does not.
  for (auto off : s.ball_off) {
    ASSERT_GT(off.size(), 8u);
    std::nth_element(off.begin(), off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2), off.end());
    EXPECT_LT(off[off.size() / 2], 8.0);
  }
  ASSERT_GT(s.disparity.body.count(), 10u);
  EXPECT_LT(s.disparity.body.rms(), 0.1);
}

// What a page marks as a landmark lies on one, in its own eye's half.
TEST(StereoPlay, LandmarksAreMarkedWhereThePictureHasThem) {
  const auto s = play_with_two_eyes(two_eyed_world(), {}, 0.3, true);
  ASSERT_FALSE(s.play.frames.empty());
  for (const auto& frame : s.play.frames) {
    const auto& record = frame.record;
    std::array<int, 2> marked{};
    for (const auto& mark : server::graphics::shown_picture(record).landmarks) {
      const bool right = mark.x >= 640.0;
      const auto X = (right ? record.right->X_world_camera : record.X_world_camera).inverse();
      const auto& lens = (right ? s.rig.right_camera : s.rig.camera)->model;
      double off = 1e9;
      for (const auto& landmark : s.rig.landmarks) {
        const Vector3 p = (X * landmark.place).m;
        const device::Pixel mark_in_eye(mark.x - (right ? 640.0 : 0.0), mark.y);
        if (p.z() > 0.1) off = std::min(off, (lens.project_undistorted(p) - mark_in_eye).norm());
      }
      if (mark.used) {
        EXPECT_LT(off, 1.0);
      }
      marked[right ? 1 : 0] += mark.used ? 1 : 0;
    }
    EXPECT_GE(marked[0], 4);
    EXPECT_GE(marked[1], 4);
    EXPECT_LE(marked[0], record.landmarks_used);
    EXPECT_LE(marked[1], record.right->landmarks_used);
  }
}

constexpr double kTurn = 0.002;  // rad, about the camera's own y

// The instrument can fail: an eye that is calibrated wrongly by a known turn is off by what theory says, the
// other is not.
TEST(StereoPlay, ATurnOfTheRightCameraIsSeenInItsPictureAloneAndInTheDisparity) {
  auto file = two_eyed_world();
  file.tracker.white_rms = file.tracker.bias_rms = file.tracker.dropout = 0.0;
  const auto s = play_with_two_eyes(file, {}, 3.0, false, [](rig::Rig& rig) {
    auto& X = rig.right_hand_eye->X_marker_camera;
    X.rotation = X.rotation * so3_exp(Vector3(0.0, kTurn, 0.0));
  });
  EXPECT_LT(s.left.world.rms(), 0.1);
  // Sideways f (1 + x^2) kTurn: least in the middle of the picture, a seventh more at its edges.
  const double middle = s.rig.right_camera->model.fx * kTurn;
  EXPECT_GT(s.right.world.rms(), 0.99 * middle);
  EXPECT_LT(s.right.world.rms(), 1.15 * middle);
  EXPECT_NEAR(s.disparity.world.rms(), s.right.world.rms(), 0.05 * middle);
}

TEST(StereoPlay, CamerasWithAClockEachArePairedByIt) {
  LockstepOptions options;
  options.right_camera_own_clock = true;
  options.disturb_right_camera = [](double, std::optional<device::CameraImage>& image) {
    if (image) image->mid_exposure += seconds(1000.0);
  };
  const auto s = play_with_two_eyes(two_eyed_world(), options, 3.0);
  EXPECT_GT(s.play.frames.size(), 85u);
  for (const auto& frame : s.play.frames) ASSERT_TRUE(frame.record.right);
}

// A driver that knows when an image came may hand it out late: its moment is known all the same.
TEST(StereoPlay, ImagesHandedOutLateArePairedWhereTheirDriverSaysHowLate) {
  for (const server::graphics::EyeSide side :
       {server::graphics::EyeSide::left, server::graphics::EyeSide::right})
    for (const bool says : {true, false}) {
      LockstepOptions options;
      options.right_camera_own_clock = true;
      std::optional<device::CameraImage> held;
      double due = 0.0;
      const auto hold = [&](double t, std::optional<device::CameraImage>& image) {
        if (image) {
          held = std::exchange(image, std::nullopt);
          due = t + 0.0205;
        } else if (held && t >= due) {
          image = std::exchange(held, std::nullopt);
          if (says) image->waited = seconds(0.021);
        }
      };
      (side == server::graphics::EyeSide::left ? options.disturb_left_camera : options.disturb_right_camera) =
          hold;
      const auto s = play_with_two_eyes(two_eyed_world(), options, 3.0);
      int paired = 0;
      for (const auto& frame : s.play.frames) paired += frame.record.right ? 1 : 0;
      const char* which = side == server::graphics::EyeSide::left ? "left" : "right";
      if (says)
        EXPECT_GT(paired, 80) << which;
      else
        EXPECT_LT(paired, 10) << which;
    }
}

TEST(StereoPlay, WhereACameraLosesAnImageNeitherEyeSeesThatMoment) {
  auto file = two_eyed_world();
  file.camera.drop = 0.1;
  const auto s = play_with_two_eyes(file, {}, 6.0);
  // Of 180 moments both cameras have 0.9^2: 146, deviation 5.
  EXPECT_GT(s.play.frames.size(), 125u);
  EXPECT_LT(s.play.frames.size(), 165u);
  for (const auto& frame : s.play.frames) ASSERT_TRUE(frame.record.right);
}

TEST(StereoPlay, ARigOfTwoCamerasPlaysWithTheLeftOneInAWorldOfOne) {
  auto file = two_eyed_world();
  auto one = file;
  one.camera.count = 1;
  const auto s = play_with_two_eyes(one, {}, 1.0, false, [](rig::Rig& rig) {
    rig.right_camera = rig.camera;
    rig.right_hand_eye = rig.hand_eye;
  });
  ASSERT_GT(s.play.frames.size(), 25u);
  for (const auto& frame : s.play.frames) EXPECT_FALSE(frame.record.two_eyes);
}

// --- the right camera fails

struct ToldOfRightEye {
  double first_s = 0.0, last_s = 0.0;
  std::string words;
  std::map<device::HealthCode, int> kinds;
};

constexpr double kRightFails = 3.0, kRightIsBack = 4.5;  // s, of the play, warm-up counted

ToldOfRightEye while_right_fails(const std::function<void(std::optional<device::CameraImage>&)>& how) {
  ToldOfRightEye told;
  LockstepOptions options;
  options.disturb_right_camera = [&](double t, std::optional<device::CameraImage>& image) {
    if (t >= kRightFails && t < kRightIsBack) how(image);
  };
  options.conditions = [&](double t, const std::vector<server::graphics::Condition>& conditions) {
    for (const auto& condition : conditions) {
      if (t < 2.0) continue;
      if (told.kinds[condition.code]++ == 0) told.first_s = t;
      told.last_s = t;
      told.words = condition.words;
    }
  };
  const auto s = play_with_two_eyes(two_eyed_world(), options, 5.0);
  // No frame is held up for longer than the wait for the right camera, and both eyes are back at the end.
  double before = 2.0;
  int alone = 0;
  for (const auto& frame : s.play.frames) {
    const double t = frame.record.begun.seconds() - s.play.frames.front().record.begun.seconds() + 2.0;
    EXPECT_LT(t - before, 0.34);
    before = t;
    alone += frame.record.right ? 0 : 1;
    EXPECT_TRUE(frame.record.two_eyes);
  }
  EXPECT_NEAR(alone, 30.0 * (kRightIsBack - kRightFails - 0.25), 4.0);
  EXPECT_TRUE(s.play.frames.back().record.right);
  EXPECT_EQ(s.play.haptic.fault_ticks, 0u);
  return told;
}

TEST(StereoPlay, ARightCameraThatStopsIsToldAndTheLeftOneGoesOnForBothEyes) {
  const auto told = while_right_fails([](std::optional<device::CameraImage>& image) { image.reset(); });
  EXPECT_EQ(told.kinds.size(), 1u);
  EXPECT_EQ(told.kinds.begin()->first, device::HealthCode::right_eye_lost);
  EXPECT_GT(told.first_s, kRightFails);
  EXPECT_LT(told.first_s, kRightFails + 0.5);
  EXPECT_LT(told.last_s, kRightIsBack + 0.1);
  EXPECT_NE(told.words.find("right camera: no image"), std::string::npos) << told.words;
}

TEST(StereoPlay, RightImagesOfTheWrongSizeAreToldWithBothSizes) {
  const auto told = while_right_fails([](std::optional<device::CameraImage>& image) {
    if (image) image->width = 320, image->height = 240;
  });
  EXPECT_LT(told.first_s, kRightFails + 0.5);
  EXPECT_NE(told.words.find("320 x 240 pixels, the rig is calibrated for 640 x 480"), std::string::npos)
      << told.words;
}

TEST(StereoPlay, ARightCameraThatExposesAtOtherMomentsIsNotBelieved) {
  const auto told = while_right_fails([](std::optional<device::CameraImage>& image) {
    if (image) image->mid_exposure += std::chrono::milliseconds(16);
  });
  EXPECT_LT(told.first_s, kRightFails + 0.5);
  EXPECT_NE(told.words.find("taken together"), std::string::npos) << told.words;
}

}  // namespace
}  // namespace palpate::sim::lockstep
