// What a frame is drawn with when replies, images or the tracker's samples come late, do not come, or come again: on a
// virtual clock, without pixels.
#include "palpate/server/graphics/graphics_server.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>

#include "palpate/server/graphics/devices_for_tests.h"
#include "palpate/transport/exchange_rig_test.h"

namespace palpate::server::graphics {
namespace {

constexpr Duration kOneMs = std::chrono::milliseconds(1);
constexpr int kImageEvery = 40, kSampleEvery = 10, kDrawnAfter = 8;  // ms
constexpr double kHeadSpeed = 0.3;                                   // m/s along x

// Keeps what is to be drawn.
class DrawnFrames : public NullFramePipeline {
 public:
  std::vector<std::uint64_t> images;
  void draw(const device::CameraImage& image, const device::CameraImage*, FrameRecord&) override {
    images.push_back(image.frame);
  }
};

// A head that moves steadily, seen by camera and tracker whose stamps are true time; a physics server 93 s ahead of us
// whose body 0 is at x = its time (exchange_rig_test.h).
class FramesOfAServer : public ::testing::Test {
 protected:
  void make(const GraphicsSettings& settings = {}) {
    server_ =
        std::make_unique<GraphicsServer>(calibrated_rig(), *link_, tracker_, camera_, pipeline_, settings);
  }
  void SetUp() override { make(); }

  // Milliseconds of true time, from 0 on; frames are finished where they are due.
  void run(int milliseconds, bool images = true, bool samples = true) {
    for (int i = 0; i < milliseconds; ++i) {
      exchange_.wait_a_little();
      ++ms_;
      if (images && ms_ % kImageEvery == 0) hand_image();
      if (samples && ms_ % kSampleEvery == 0) hand_sample();
      server_->service(now());
      if (!server_->frame_begun() && server_->begin_frame(now())) begun_ms_ = ms_;
      if (!server_->frame_begun() || ms_ < begun_ms_ + kDrawnAfter) continue;
      frames_.push_back(server_->finish_frame(now()));
      if (shown_after_) server_->shown(now() + *shown_after_);
      if (drawing_takes_) show_when_due((*drawing_takes_)(frames_.size()));
    }
  }
  void show_when_due(Duration drawing) {
    const auto ready = now() + drawing;
    const auto due = server_->ready(ready);
    held_.push_back(due - ready);
    shown_.push_back(due);
    server_->shown(due);
  }
  void hand_image(int width = 640) {
    camera_.next =
        device::CameraImage{{ms_ * kOneMs}, static_cast<std::uint64_t>(ms_ / kImageEvery), width, 480, {}};
  }
  void hand_sample() {
    device::TrackerSample sample;
    sample.stamp = {ms_ * kOneMs};
    sample.marker = device::MarkerId::camera_marker;
    sample.seen = true;
    sample.translation = Vector3(kHeadSpeed * 1e-3 * ms_, 0, 0);
    tracker_.next.push_back(sample);
  }
  Instant<GraphicsClock> now() const { return {exchange_.network.now().since_epoch + seconds(7.0)}; }
  // True time at which the frame's image was taken, and that its state and its pose are of, s.
  static double image_s(const FrameRecord& frame) {
    return 1e-3 * kImageEvery * static_cast<double>(frame.camera_frame);
  }
  static double state_s(const FrameRecord& frame) { return frame.state.bodies[0].position[0] - 100.0; }
  static double pose_s(const FrameRecord& frame) { return frame.X_world_camera.translation.x() / kHeadSpeed; }
  void replies_take(Duration one_way) {
    exchange_.network.set_model({.delay = one_way, .jitter = Duration(0)});
  }

  transport::testing::InProcessRig exchange_{
      {.delay = std::chrono::microseconds(700), .jitter = Duration(0)}};
  std::unique_ptr<transport::StateService> service_ = std::move(*exchange_.serve());
  std::unique_ptr<transport::StateLink> link_ = exchange_.connect();
  HandedCamera camera_;
  HandedTracker tracker_;
  DrawnFrames pipeline_;
  std::unique_ptr<GraphicsServer> server_;
  std::vector<FrameRecord> frames_;
  int ms_ = 0, begun_ms_ = 0;
  std::optional<Duration> shown_after_;  // a frame was finished; none: nobody says so
  std::optional<std::function<Duration(std::size_t frame)>>
      drawing_takes_;  // then it is shown when it is due
  std::vector<Duration> held_;
  std::vector<Instant<GraphicsClock>> shown_;
};

// Clocks are known to some ten microseconds by then.
constexpr double kSettled_s = 1e-4;

TEST_F(FramesOfAServer, EachImageIsDrawnOnceWithStateAndPoseOfItsMoment) {
  run(2000);
  ASSERT_EQ(frames_.size(), 49u) << "the last image is taken up and not finished";
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    EXPECT_EQ(frames_[i].number, i + 1);
    EXPECT_EQ(pipeline_.images[i], i + 1);
  }
  for (std::size_t i = 25; i < frames_.size(); ++i) {
    const FrameRecord& frame = frames_[i];
    EXPECT_TRUE(frame.requested && frame.have_state && !frame.late) << i;
    EXPECT_EQ(frame.answer, AnswerKind::interpolated);
    EXPECT_NEAR(state_s(frame), image_s(frame), kSettled_s) << i;
    EXPECT_EQ(frame.pose_source, PoseSource::tracker);
    EXPECT_NEAR(pose_s(frame), image_s(frame), kSettled_s) << i;
    EXPECT_EQ(to_seconds(frame.drawn - frame.begun), 1e-3 * kDrawnAfter);
  }
}

// All but the newest, which may still be asked for.
TEST_F(FramesOfAServer, ImagesAreGivenBackToTheirCamera) {
  run(500);
  ASSERT_GE(frames_.size(), 8u);
  std::vector<std::uint64_t> drawn{0};  // before the first picture there was none
  for (const auto& frame : frames_) drawn.push_back(frame.camera_frame);
  drawn.pop_back();
  EXPECT_EQ(camera_.back, drawn);
  EXPECT_EQ(server_->finished_image().frame, frames_.back().camera_frame);
}

TEST_F(FramesOfAServer, AReplyThatComesAfterTheDrawingLeavesThePreviousState) {
  run(1000);
  replies_take(std::chrono::milliseconds(15));  // 30 ms, which drawing does not wait for
  run(400);
  for (std::size_t i = frames_.size() - 5; i < frames_.size(); ++i) {
    EXPECT_TRUE(frames_[i].late) << i;
    EXPECT_TRUE(frames_[i].have_state);
    EXPECT_NEAR(state_s(frames_[i]), image_s(frames_[i - 1]), 2 * kSettled_s)
        << "that of the image before " << i;
  }
  replies_take(std::chrono::microseconds(700));
  run(400);
  EXPECT_FALSE(frames_.back().late);
  EXPECT_NEAR(state_s(frames_.back()), image_s(frames_.back()), 2 * kSettled_s);
}

TEST_F(FramesOfAServer, NothingOfAnotherApplicationIsDrawnUntilTheFirstIsBack) {
  server_->set_drawn(transport::testing::table_scene());
  const auto serve_next = [&](scene::SceneDescription scene) {
    service_.reset();
    run(1000);
    service_ = std::move(*exchange_.serve(std::move(scene)));
    run(1000);
  };
  const auto words = [&] { return server_->conditions().empty() ? "" : server_->conditions()[0].words; };
  run(1000);
  EXPECT_TRUE(frames_.back().have_state && !frames_.back().other_scene);
  EXPECT_EQ(words(), "");
  serve_next(transport::testing::table_scene("touch"));
  EXPECT_TRUE(frames_.back().other_scene && !frames_.back().have_state);
  EXPECT_EQ(words(), "the physics server now plays touch, not marbles; start `palpate graphics` again");
  auto moved = transport::testing::table_scene();
  for (auto& corner : moved.surfaces[0].corners) corner.x() += 0.3;
  serve_next(moved);
  run(500);
  EXPECT_TRUE(frames_.back().have_state && !frames_.back().other_scene);
  EXPECT_EQ(
      words(),
      "the physics server has another rig: 'table' lies 300 mm from where it lies here; both servers need "
      "the same rig file");
  serve_next(transport::testing::table_scene());
  run(500);
  EXPECT_TRUE(frames_.back().have_state);
  EXPECT_EQ(words(), "");
}

TEST_F(FramesOfAServer, APictureGoesOnWithTheLastStateWhileThePhysicsServerIsGone) {
  run(1000);
  const auto last = frames_.back();
  service_.reset();
  run(1200);
  EXPECT_EQ(frames_.size(), 54u);
  EXPECT_TRUE(frames_.back().late && frames_.back().have_state);
  EXPECT_FALSE(frames_.back().requested) << "nobody is asked who is gone";
  EXPECT_NEAR(state_s(frames_.back()), state_s(last), kImageEvery * 1.1e-3)
      << "that of one image more at most";
  EXPECT_NEAR(pose_s(frames_.back()), image_s(frames_.back()), kSettled_s) << "the camera's pose is ours";
  service_ = std::move(*exchange_.serve());
  run(1000);
  EXPECT_FALSE(frames_.back().late);
  EXPECT_NEAR(state_s(frames_.back()), image_s(frames_.back()), 2 * kSettled_s);
}

TEST_F(FramesOfAServer, BeforeThePhysicsServerHasAnsweredThereIsNoStateAndNoRequest) {
  service_.reset();
  run(200);
  ASSERT_FALSE(frames_.empty());
  EXPECT_FALSE(frames_.back().have_state || frames_.back().requested);
  EXPECT_TRUE(frames_.back().late);
}

TEST_F(FramesOfAServer, ACameraThatFallsSilentEndsTheFramesAndComesBackWithTheNextImage) {
  run(1000);
  const auto before = frames_.size();
  run(1000, false);
  EXPECT_LE(frames_.size(), before + 1) << "the one begun";
  EXPECT_FALSE(server_->begin_frame(now()));
  const auto silent = frames_.size();
  ASSERT_EQ(server_->conditions().size(), 1u);
  run(1000);
  EXPECT_EQ(frames_.size(), silent + 25 - 1);
  EXPECT_TRUE(frames_.back().conditions.empty());
  EXPECT_NEAR(state_s(frames_.back()), image_s(frames_.back()), 2 * kSettled_s);
}

TEST_F(FramesOfAServer, OfTwoImagesTheNewerIsDrawn) {
  run(1010);
  const auto drawn = pipeline_.images.size();
  for (int image = 0; image < 2; ++image) {  // taken up by nobody meanwhile
    ms_ += kImageEvery;
    exchange_.network.advance_to(exchange_.network.now() + kImageEvery * kOneMs);
    hand_image();
    hand_sample();
    server_->service(now());
  }
  ASSERT_TRUE(server_->begin_frame(now()));
  EXPECT_FALSE(server_->begin_frame(now())) << "once";
  EXPECT_EQ(server_->finish_frame(now()).camera_frame, 27u);
  ASSERT_EQ(pipeline_.images.size(), drawn + 1);
  EXPECT_EQ(pipeline_.images.back(), 27u);
  EXPECT_FALSE(server_->frame_begun());
}

TEST_F(FramesOfAServer, ImagesThatAreHeldBackAllComeAndSoMuchLater) {
  make({.extra_delay = std::chrono::milliseconds(100)});
  run(2000);
  for (std::size_t i = 0; i < pipeline_.images.size(); ++i) EXPECT_EQ(pipeline_.images[i], i + 1);
  ASSERT_GE(frames_.size(), 46u);
  EXPECT_EQ(to_seconds(frames_.back().begun - frames_.back().arrived), 0.1);
  EXPECT_NEAR(state_s(frames_.back()), image_s(frames_.back()), kSettled_s) << "as old as the image";
}

TEST_F(FramesOfAServer, WhileTheTrackerIsBlindTheLastPoseStaysAndNothingIsSaidToBeKnown) {
  run(1000);
  run(400, true, false);
  const auto blind = frames_.back();
  EXPECT_EQ(blind.pose_source, PoseSource::none);
  EXPECT_FALSE(blind.have_tracker);
  EXPECT_NEAR(pose_s(blind), 1.0, 1e-3 * kImageEvery) << "where it was seen last";
  run(400);
  EXPECT_EQ(frames_.back().pose_source, PoseSource::tracker);
  EXPECT_NEAR(pose_s(frames_.back()), image_s(frames_.back()), kSettled_s);
}

TEST_F(FramesOfAServer, ASampleThatComesWhileTheFrameIsDrawnIsTaken) {
  run(995);
  ms_ += 5, exchange_.network.advance_to(exchange_.network.now() + 5 * kOneMs);
  hand_image();
  server_->service(now());  // the sample of this moment is not here yet
  ASSERT_TRUE(server_->begin_frame(now()));
  hand_sample();
  const FrameRecord& frame = server_->finish_frame(now());
  EXPECT_EQ(frame.pose_source, PoseSource::tracker);
  EXPECT_NEAR(pose_s(frame), 1.0, kSettled_s);
}

TEST_F(FramesOfAServer, AnImageOfAnotherSizeIsNotDrawn) {
  run(1010);
  const auto drawn = pipeline_.images.size();
  hand_image(320);
  server_->service(now());
  EXPECT_FALSE(server_->begin_frame(now()));
  EXPECT_EQ(pipeline_.images.size(), drawn);
  EXPECT_EQ(server_->conditions().size(), 1u);
}

TEST_F(FramesOfAServer, APredictedPictureIsOfTheMomentItsLightLeavesTheDisplay) {
  make({.picture_time = PictureTime::predicted, .scan_out = std::chrono::milliseconds(12)});
  run(2000);
  const FrameRecord& frame = frames_.back();
  EXPECT_EQ(frame.answer, AnswerKind::extrapolated);
  const double photon_s = to_seconds(frame.photon.since_epoch) - 7.0;
  EXPECT_NEAR(photon_s, to_seconds(frame.begun.since_epoch) - 7.0 + 1e-3 * (kDrawnAfter + 12), 1e-3);
  EXPECT_NEAR(to_seconds(frame.state.time.since_epoch) - 100.0, photon_s, kSettled_s);
  EXPECT_NEAR(pose_s(frame), photon_s, 1e-3);
}

TEST_F(FramesOfAServer, APredictedPictureReckonsWithTheTimeThatDrawingTook) {
  make({.picture_time = PictureTime::predicted, .scan_out = std::chrono::milliseconds(12)});
  shown_after_ = 9 * kOneMs;
  run(2000);
  const FrameRecord& frame = frames_.back();
  EXPECT_NEAR(to_seconds(frame.photon - frame.drawn), 1e-3 * (9 + 12), 1e-6);
  EXPECT_NEAR(pose_s(frame), to_seconds(frame.photon.since_epoch) - 7.0, 1e-3);
}

TEST_F(FramesOfAServer, APictureThatIsReadyEarlyIsHeldAndKnewIt) {
  make({.picture_time = PictureTime::predicted, .scan_out = std::chrono::milliseconds(12)});
  drawing_takes_ = [](std::size_t frame) { return (frame % 2 == 0 ? 4 : 6) * kOneMs; };
  run(4000);
  for (std::size_t i = frames_.size() - 10; i < frames_.size(); ++i) {
    EXPECT_NEAR(to_seconds(held_[i]), (i + 1) % 2 == 0 ? 2e-3 : 0.0, 2 * kSettled_s) << i;
    EXPECT_NEAR(to_seconds(frames_[i].photon - shown_[i]), 12e-3, 2 * kSettled_s) << i;
  }
  hand_image();
  server_->service(now());
  EXPECT_EQ(server_->ready(now()), now()) << "the next image waits";
}

TEST_F(FramesOfAServer, NothingIsHeldForAHeadset) {
  make();
  server_->set_display([](Instant<GraphicsClock> finished) { return finished + 23 * kOneMs; });
  drawing_takes_ = [](std::size_t frame) { return (frame % 2 == 0 ? 4 : 6) * kOneMs; };
  run(4000);
  for (const auto held : held_) EXPECT_EQ(held, Duration(0));
}

// Body 0 goes at 1 m/s and does not say so: a state shows it as far behind as the state is old.
TEST_F(FramesOfAServer, HowWellAPictureWasPredictedIsKnownSoonAfter) {
  make({.picture_time = PictureTime::predicted, .scan_out = std::chrono::milliseconds(12)});
  shown_after_ = 9 * kOneMs;
  run(2000);
  const auto errors = server_->take_prediction_errors();
  ASSERT_GT(errors.size(), 40u);
  for (std::size_t i = 25; i < errors.size(); ++i) {
    const FrameRecord& frame = frames_[errors[i].frame - 1];
    const double light_s = to_seconds(frame.photon.since_epoch) - 7.0;
    EXPECT_NEAR(errors[i].moment_s, 0.0, 1e-6);
    EXPECT_NEAR(errors[i].ahead_s, 1e-3 * (kDrawnAfter + 9 + 12), 1e-3);
    ASSERT_TRUE(errors[i].bodies.at(0));
    EXPECT_NEAR(errors[i].bodies[0]->newest, errors[i].ahead_s, 3 * kSettled_s);
    EXPECT_NEAR(errors[i].bodies[0]->shown, errors[i].ahead_s, 3 * kSettled_s);
    EXPECT_NEAR(errors[i].bodies[0]->registered, light_s - image_s(frame), 3 * kSettled_s);
    ASSERT_TRUE(errors[i].head_m);
    EXPECT_NEAR(*errors[i].head_m, 0.0, 1e-3 * kHeadSpeed);
  }
  EXPECT_TRUE(server_->take_prediction_errors().empty());
}

// By its velocity alone what the stylus carries (exchange_rig_test.h) would be 0.5 x 3 m/s^2 x (20 ms)^2 = 0.6 mm behind.
TEST_F(FramesOfAServer, AHandThatSpeedsUpIsCarriedOnSo) {
  make({.picture_time = PictureTime::predicted, .scan_out = std::chrono::milliseconds(12)});
  run(2000);
  const FrameRecord& frame = frames_.back();
  const double ahead = to_seconds(frame.extrapolated_by), light = frame.state.time.seconds();
  EXPECT_NEAR(ahead, 1e-3 * (kDrawnAfter + 12), 1e-3);
  EXPECT_NEAR(frame.state.bodies[1].p().x(), 1.5 * light * light, 1e-5);
}

TEST_F(FramesOfAServer, APictureShownLaterThanItWasReckonedSaysByHowMuch) {
  make({.picture_time = PictureTime::predicted});
  shown_after_ = 9 * kOneMs;
  run(1000);
  server_->take_prediction_errors();
  shown_after_ = 14 * kOneMs;
  run(120);
  const auto errors = server_->take_prediction_errors();
  ASSERT_FALSE(errors.empty());
  EXPECT_NEAR(errors.back().moment_s, 5e-3, 1.5e-3);
}

TEST_F(FramesOfAServer, ARegisteredPictureIsNotLookedBackAt) {
  shown_after_ = 9 * kOneMs;
  run(1000);
  EXPECT_TRUE(server_->take_prediction_errors().empty());
}

// Which moves the picture against the head by itself.
TEST_F(FramesOfAServer, InAHeadsetOnlyTheStateIsPredictedAndTheCameraStaysAtItsImage) {
  make({.picture_time = PictureTime::predicted, .scan_out = std::chrono::milliseconds(12)});
  server_->set_display([](Instant<GraphicsClock> finished) { return finished + 23 * kOneMs; });
  run(2000);
  const FrameRecord& frame = frames_.back();
  const double photon_s = to_seconds(frame.photon.since_epoch) - 7.0;
  EXPECT_NEAR(photon_s, to_seconds(frame.begun.since_epoch) - 7.0 + 1e-3 * (kDrawnAfter + 23), 1e-3);
  EXPECT_NEAR(to_seconds(frame.state.time.since_epoch) - 100.0, photon_s, kSettled_s);
  EXPECT_NEAR(pose_s(frame), image_s(frame), kSettled_s);
}

TEST_F(FramesOfAServer, WhatCannotBeIsWrongUse) {
  const auto made = [&](const rig::Rig& rig, const GraphicsSettings& settings = {}) {
    GraphicsServer server(rig, *link_, tracker_, camera_, pipeline_, settings);
  };
  rig::Rig blind = calibrated_rig(), loose = calibrated_rig();
  blind.camera.reset(), loose.hand_eye.reset();
  EXPECT_THROW(made(blind), std::invalid_argument);
  EXPECT_THROW(made(loose), std::invalid_argument);
  EXPECT_THROW(made(calibrated_rig(), {.extra_delay = seconds(1.5)}), std::invalid_argument);
  EXPECT_THROW(made(calibrated_rig(), {.scan_out = seconds(-0.1)}), std::invalid_argument);
  EXPECT_THROW(server_->add_right_camera(camera_, true), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::server::graphics
