// Pose, state and picture belong to one moment: what it costs where they do not, what the system says when a
// device fails, and what predicted pictures and delays on purpose do. Played in lock-step, without pixels.
#include <gtest/gtest.h>

#include <map>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/specification.h"
#include "palpate/core/statistics.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/overlay_of_play.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"

namespace palpate::sim::lockstep {
namespace {

constexpr double kFrame = 1.0 / 30.0;  // s

// A tracker without noise, and a head that turns but does not shake: what is left are moments.
config::WorldFile quiet_world() {
  auto file = config::reference_world();
  file.tracker.white_rms = file.tracker.bias_rms = file.tracker.dropout = 0.0;
  file.head.shake = 0.0;
  file.camera.drop = 0.0;
  return file;
}

struct Moments {
  LockstepResult play;
  evaluation::OverlayOfPlay overlay;
  scene::SceneDescription scene;
  rig::Rig rig;
  std::vector<evaluation::CheckPoint> points;
  double head_rate_rms = 0.0;  // rad/s
};

// Blind, but bodies move on as the application has it.
class PredictingPipeline : public server::graphics::NullFramePipeline {
 public:
  explicit PredictingPipeline(const scene::SceneView& view) : view_(view) {}
  scene::SceneState predict(const scene::SceneState& state, Duration ahead) override {
    return view_.predict(state, ahead);
  }

 private:
  const scene::SceneView& view_;
};

Moments play_moments(const config::WorldFile& file, LockstepOptions options, double seconds_played,
                     const std::function<void(rig::Rig&)>& change = {}) {
  Simulator world(file, 3);
  Moments m;
  m.rig = truth_rig(world);
  if (change) change(m.rig);
  m.scene = server::physics::scene_from_rig(
      m.rig, *sim::config::scene_of(file, {applications::pingpong::specification()}, "pingpong"));
  options.applications = {applications::pingpong::specification()};
  options.seconds = seconds_played;
  options.seed = 3;
  auto scene_view = options.applications.make_view(m.scene);
  EXPECT_TRUE(scene_view.has_value());
  PredictingPipeline pipeline(**scene_view);
  LockstepPictures pictures;
  pictures.pipeline = &pipeline;
  auto result = play_in_lockstep(world, m.rig, m.scene, options, pictures, {});
  EXPECT_TRUE(result.has_value()) << result.error().message;
  m.play = std::move(*result);
  m.points = evaluation::check_points(world.truth(), m.rig);
  m.overlay = evaluation::overlay_of_play(m.play.frames, m.rig.camera->model, m.points);
  return m;
}

// rms over all check points in view of how far their pictures move while the camera goes from one pose to the
// next, found from its angular and linear velocity alone: the equations of optical flow (Longuet-Higgins &
// Prazdny 1980, equation 2.8), not the code that draws.
double flow_px(const evaluation::CameraView& a, const evaluation::CameraView& b,
               const std::vector<evaluation::CheckPoint>& points) {
  const Quaternion turn = a.X_world_camera.rotation.conjugate() * b.X_world_camera.rotation;
  const Vector3 w = so3_log(turn);  // of the camera, in its own axes
  const Vector3 v =
      a.X_world_camera.rotation.conjugate() * (b.X_world_camera.translation - a.X_world_camera.translation);
  double sum = 0.0;
  int count = 0;
  for (const auto& point : points) {
    if (!evaluation::real_pixel(b, b.lens, point.truth)) continue;
    const auto middle = interpolate(a.X_world_camera, b.X_world_camera, 0.5);
    const Vector3 p = (middle.inverse() * Point<World>{point.truth}).m;
    const double x = p.x() / p.z(), y = p.y() / p.z();
    const double u = (-v.x() + x * v.z()) / p.z() + x * y * w.x() - (1 + x * x) * w.y() + y * w.z();
    const double t = (-v.y() + y * v.z()) / p.z() + (1 + y * y) * w.x() - x * y * w.y() - x * w.z();
    sum += std::pow(b.lens.fx * u, 2) + std::pow(b.lens.fy * t, 2);
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

TEST(Moment, APoseOneFrameOldCostsWhatTheHeadsTurnSays) {
  auto m = play_moments(quiet_world(), {}, 5.0);
  ASSERT_GT(m.play.frames.size(), 140u);
  EXPECT_LT(m.overlay.world.rms(), 0.1) << "in time there is next to nothing";
  LockstepResult stale = m.play;
  double theory = 0.0;
  for (std::size_t i = 1; i < stale.frames.size(); ++i) {
    stale.frames[i].record.X_world_camera = m.play.frames[i - 1].record.X_world_camera;
    theory += flow_px(m.play.frames[i - 1].truth, m.play.frames[i].truth, m.points) /
              static_cast<double>(stale.frames.size() - 1);
  }
  stale.frames.erase(stale.frames.begin());
  const double error = evaluation::overlay_of_play(stale.frames, m.rig.camera->model, m.points).world.rms();
  // The flow is that of the middle of the step: off by the turn's curvature, some per cent.
  EXPECT_NEAR(error / std::sqrt(theory), 1.0, 0.05);
  // And by hand: 50 deg/s at the peak of a sine, a thirtieth of a second, 560 px; the head is bent down by 30
  // degrees, so that a part of the turn rolls the picture about its middle.
  const double by_hand = 560.0 * radians_from_degrees(50.0) / std::sqrt(2.0) * kFrame;
  EXPECT_GT(error, 0.7 * by_hand);
  EXPECT_LT(error, 1.5 * by_hand);
}

TEST(Moment, AStateOneFrameOldCostsWhatTheTipsSpeedSays) {
  auto m = play_moments(quiet_world(), {}, 8.0);
  const double in_time = m.overlay.tip.rms();
  LockstepResult stale = m.play;
  double theory = 0.0;
  int count = 0;
  for (std::size_t i = 1; i < stale.frames.size(); ++i) {
    const auto &now = m.play.frames[i], &before = m.play.frames[i - 1];
    stale.frames[i].record.state = before.record.state;
    stale.frames[i].shown_tip = before.shown_tip;
    if (!evaluation::real_pixel(now.truth, m.rig.camera->model, now.true_tip)) continue;
    // Way of the tip across the line of sight, over its distance.
    const Vector3 ray = now.true_tip - now.truth.X_world_camera.translation;
    const Vector3 way = now.true_tip - before.true_tip;
    const double depth = (now.truth.X_world_camera.rotation.conjugate() * ray).z();
    const Vector3 across = way - way.dot(ray) / ray.squaredNorm() * ray;
    theory += std::pow(560.0 * across.norm() / depth, 2);
    ++count;
  }
  stale.frames.erase(stale.frames.begin());
  const double error = evaluation::overlay_of_play(stale.frames, m.rig.camera->model, m.points).tip.rms();
  ASSERT_GT(count, 100);
  EXPECT_GT(error, 5.0 * in_time);
  // Off the picture's middle a degree takes more pixels: up to a tenth here.
  EXPECT_NEAR(error / std::sqrt(theory / count), 1.0, 0.12);
}

TEST(Moment, WithoutTheCamerasDelayEveryPictureIsThatMuchTooLate) {
  const auto file = quiet_world();
  const double late = file.camera.latency_s - file.tracker.latency_s;
  const auto m = play_moments(file, {}, 5.0, [](rig::Rig& rig) { rig.delays->camera_after_tracker_s = 0.0; });
  const double by_hand = 560.0 * radians_from_degrees(50.0) / std::sqrt(2.0) * late;
  EXPECT_GT(m.overlay.world.rms(), 0.7 * by_hand);
  EXPECT_LT(m.overlay.world.rms(), 1.5 * by_hand);
}

// --- predicted pictures

TEST(Moment, APredictedPictureShowsTheTipWhereItIsWhenItsLightLeaves) {
  LockstepOptions registered, predicted;
  predicted.graphics.picture_time = server::graphics::PictureTime::predicted;
  const auto then = play_moments(quiet_world(), registered, 8.0),
             now = play_moments(quiet_world(), predicted, 8.0);
  ErrorSummary behind, ahead, turn;
  for (std::size_t i = 0; i + 2 < then.play.frames.size(); ++i) {
    const auto& frame = then.play.frames[i];
    // Where the tip is when a registered picture is seen: 52 ms on, nearly the truth of the frame but one
    // after.
    behind.add(1e3 *
               (scene::shown_tip(frame.record.state, then.scene) - then.play.frames[i + 2].true_tip).norm() *
               52.0 / 66.7);
  }
  for (const auto& frame : now.play.frames) {
    ahead.add(1e3 * (scene::shown_tip(frame.record.state, now.scene) - frame.true_tip).norm());
    turn.add(angle_between(frame.record.X_world_camera.rotation, frame.truth.X_world_camera.rotation));
    EXPECT_EQ(frame.record.answer, AnswerKind::extrapolated);
    EXPECT_LT(std::abs(to_seconds(frame.record.photon - frame.record.drawn)), 0.002);
  }
  // A hand of up to 30 m/s^2 strays from a straight line by 0.5 a t^2 = 3 mm within the 14 ms that are left
  // to predict; from where it was 52 ms ago it strays by its whole way.
  EXPECT_LT(ahead.rms(), 3.0);
  EXPECT_GT(behind.rms(), 3.0 * ahead.rms());
  // What the servers find out by themselves, beside the truth: the arm's errors are in one alone.
  ErrorSummary found, not_carried_on;
  for (const auto& error : now.play.predictions) {
    ASSERT_TRUE(error.tip);
    found.add(1e3 * error.tip->shown);
    not_carried_on.add(1e3 * error.tip->newest);
  }
  ASSERT_GT(found.count(), now.play.frames.size() - 10);
  EXPECT_NEAR(found.rms(), ahead.rms(), 0.15 * ahead.rms());
  EXPECT_GT(not_carried_on.rms(), 3.0 * found.rms());
  // The head: 0.5 a t^2 = 0.03 deg at 250 deg/s^2 within 15 ms, and the tracker's own delay once more.
  EXPECT_LT(turn.rms(), radians_from_degrees(0.15));
}

// --- delays on purpose

TEST(Moment, APictureHeldBackIsLaterByThatMuchAndFitsAsWell) {
  LockstepOptions options;
  options.graphics.extra_delay = std::chrono::milliseconds(80);
  const auto m = play_moments(quiet_world(), options, 4.0);
  ASSERT_GT(m.play.frames.size(), 110u) << "at the camera's rate all the same";
  for (const auto& frame : m.play.frames) {
    EXPECT_GE(to_seconds(frame.record.begun - frame.record.arrived), 0.080 - 1e-6);
    EXPECT_LE(to_seconds(frame.record.begun - frame.record.arrived), 0.115);
  }
  EXPECT_LT(m.overlay.world.rms(), 0.1);
  EXPECT_LT(m.overlay.tip.rms(), 0.5);
}

TEST(Moment, ImpossibleDelaysAreRefused) {
  const auto with = [](Duration scan_out, Duration extra, Duration force) {
    LockstepOptions options;
    options.graphics.scan_out = scan_out;
    options.graphics.extra_delay = extra;
    options.extra_force_delay = force;
    play_moments(quiet_world(), options, 0.1);
  };
  EXPECT_THROW(with(Duration(0), std::chrono::seconds(2), Duration(0)), std::invalid_argument);
  EXPECT_THROW(with(Duration(-1), Duration(0), Duration(0)), std::invalid_argument);
  EXPECT_THROW(with(Duration(0), Duration(0), std::chrono::milliseconds(300)), std::invalid_argument);
}

// --- devices that fail

struct Told {
  std::map<device::HealthCode, std::pair<double, double>> spans;  // first and last moment, s
  std::map<device::HealthCode, std::string> words;
};

constexpr double kFrom = 4.0, kUntil = 5.0;  // s, of the play, warm-up counted

using Faults = decltype(config::WorldFile::faults);

Told conditions_of(const Faults& faults, Moments* moments = nullptr) {
  Told told;
  LockstepOptions options;
  options.conditions = [&told](double t, const std::vector<server::graphics::Condition>& conditions) {
    if (t < 2.0) return;  // devices start
    for (const auto& condition : conditions) {
      told.spans.try_emplace(condition.code, t, t).first->second.second = t;
      told.words[condition.code] = condition.words;
    }
  };
  auto file = config::reference_world();
  file.faults = faults;
  auto m = play_moments(file, options, 6.0);
  // Forces do not know of it.
  EXPECT_EQ(m.play.haptic.ticks, 6000u);
  EXPECT_EQ(m.play.haptic.fault_ticks, 0u);
  EXPECT_LT(m.play.haptic.lost_impulse_rel(), 1e-9);
  // And all is well again at the end, without a restart: pose by tracker, tip in time.
  EXPECT_GT(m.play.frames.size(), 90u);
  ErrorSummary tip;
  for (const auto& frame : m.play.frames)
    if (frame.record.number + 45 > m.play.frames.back().record.number) {
      EXPECT_EQ(frame.record.pose_source, server::graphics::PoseSource::tracker);
      tip.add(1e3 * (scene::shown_tip(frame.record.state, m.scene) - frame.true_tip).norm());
    }
  EXPECT_LT(tip.rms(), 0.7);
  if (moments != nullptr) *moments = std::move(m);
  return told;
}

void expect_told(const Told& told, device::HealthCode kind, const std::string& word, double until = kUntil) {
  ASSERT_EQ(told.spans.count(kind), 1u) << word;
  EXPECT_LE(told.spans.at(kind).first, kFrom + 0.5);
  ::testing::Test::RecordProperty(std::string(device::name_of(kind)) + std::string("_told_after_ms"),
                                  static_cast<int>(std::lround(1e3 * (told.spans.at(kind).first - kFrom))));
  EXPECT_GE(told.spans.at(kind).first, kFrom);
  EXPECT_LE(told.spans.at(kind).second, until + 0.5);
  EXPECT_NE(told.words.at(kind).find(word), std::string::npos) << told.words.at(kind);
}

constexpr config::Range kSpan{kFrom, kUntil}, kFromThenOn{kFrom, 1e6};

TEST(Conditions, NothingIsToldWhileAllIsWell) { EXPECT_TRUE(conditions_of({}).spans.empty()); }

TEST(Conditions, ACameraThatStopsIsToldWithinHalfASecond) {
  const auto told = conditions_of({.camera_silent = kSpan});
  EXPECT_EQ(told.spans.size(), 1u);
  expect_told(told, device::HealthCode::camera_silent, "one every 33 ms is expected");
}

TEST(Conditions, ImagesOfTheWrongSizeAreNotDrawnAndToldWithBothSizes) {
  Moments m;
  const auto told = conditions_of({.image_size = kSpan}, &m);
  EXPECT_EQ(told.spans.size(), 1u);
  expect_told(told, device::HealthCode::image_size, "320 x 240 pixels, the rig is calibrated for 640 x 480");
  EXPECT_NEAR(static_cast<double>(m.play.frames.size()), 150.0, 4.0);  // of 180; the second is missing
}

TEST(Conditions, ATrackerThatDoesNotSeeTheHeadIsTold) {
  const auto told = conditions_of({.tracker_blind = kSpan});
  EXPECT_EQ(told.spans.size(), 1u);
  expect_told(told, device::HealthCode::tracker_blind, "head's marker");
}

TEST(Conditions, ATrackerWithoutSamplesIsTold) {
  const auto told = conditions_of({.tracker_silent = kSpan});
  EXPECT_EQ(told.spans.size(), 1u);
  expect_told(told, device::HealthCode::tracker_silent, "no samples");
}

TEST(Conditions, ATrackerClockThatJumpsIsToldAndLearnedAnew) {
  for (const double jump_s : {0.5, -0.3, 40.0, -40.0}) {
    const auto told = conditions_of({.tracker_clock = kFromThenOn, .clock_jump_s = jump_s});
    EXPECT_EQ(told.spans.size(), 1u) << jump_s;
    expect_told(told, device::HealthCode::tracker_clock, "tracker: its clock", kFrom + 1.2);
  }
}

TEST(Conditions, ACameraClockThatJumpsIsToldAndLearnedAnew) {
  for (const double jump_s : {0.5, -0.3, 40.0, -40.0}) {
    const auto told = conditions_of({.camera_clock = kFromThenOn, .clock_jump_s = jump_s});
    EXPECT_EQ(told.spans.size(), 1u) << jump_s;
    expect_told(told, device::HealthCode::camera_clock, "clock", kFrom + 1.2);
  }
}

}  // namespace
}  // namespace palpate::sim::lockstep
