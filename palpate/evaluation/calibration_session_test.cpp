// A session with the simulated laboratory that breaks off and goes on.
#include "palpate/calibration/session/calibration_session.h"

#include <gtest/gtest.h>

#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/sim/camera_renderer.h"

namespace palpate::evaluation {
namespace {

// A pointer's tip and surfaces within seconds.
calibration::session::CalibrationPlan quick_beginning() {
  calibration::session::CalibrationPlan plan;
  plan.corner_rounds = 1;
  plan.pivot_poses = 60;
  plan.pivot_s = 6.0;
  return plan;
}

TEST(CalibrationSession, GoesOnWhereItBrokeOff) {
  sim::config::WorldFile file = sim::config::reference_world();
  sim::CameraRenderer renderer;
  sim::Simulator world(file, 4);
  world.set_renderer(
      [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) { renderer.render(view, rgb); });
  rig::Rig rig = blank_rig(file);
  calibration::session::CalibrationPlan plan = quick_beginning();
  plan.arm_points = plan.arm_test_points = 20;
  plan.guided = false;
  plan.moving_s = 3.0;
  plan.board_s = 5.0;
  plan.board_every = 4;
  plan.lens_views = 15;
  plan.look_s = 1.0;
  plan.reach = reach_of(file);

  std::vector<std::string> begun;
  std::string full_after = "lens and hand-eye";
  calibration::session::SessionHooks hooks;
  hooks.progress = [&begun](std::size_t, std::size_t, const std::string& name) { begun.push_back(name); };
  hooks.save = [&](const rig::Rig&) -> Expected<void> {
    if (begun.back() == full_after) return refused("the disk is full");
    return {};
  };
  hooks.find_landmarks = calibration::session::landmark_finder();
  const auto first = calibration::session::calibrate_rig(laboratory_of(world), rig, plan, hooks);
  ASSERT_FALSE(first);
  EXPECT_EQ(first.error().message, "the disk is full");
  ASSERT_TRUE(rig.camera && rig.hand_eye && rig.arm);
  EXPECT_EQ(rig.registration_covariance.size(), 0);
  const device::CameraModel lens = rig.camera->model;
  const Vector3 tip = rig.pointer_pivot->tip_in_marker;

  full_after.clear();
  std::vector<std::string> kept;
  hooks.kept = [&kept](const std::string& name, const std::string& words) {
    kept.push_back(name + ": " + words);
  };
  const auto rest = calibration::session::calibrate_rig(laboratory_of(world), rig, plan, hooks);
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_EQ(rig.pointer_pivot->tip_in_marker, tip);
  ASSERT_GE(kept.size(), 6u) << "all steps but the last";
  EXPECT_EQ(kept.front().find("pointer tip: the tip is at"), 0u) << kept.front();
  EXPECT_EQ(kept.back().find("lens and hand-eye: lens"), 0u) << kept.back();
  EXPECT_TRUE(rest->pointer_pivot.empty() && rest->arm_train.empty() && rest->camera.lens_views.empty())
      << "it was there";
  EXPECT_GT(rig.registration_covariance.size(), 0);
  EXPECT_GT(rest->camera.landmark_rms_px, 0.0);
  EXPECT_LT(rest->camera.landmark_rms_px, rest->camera.landmark_rms_px_before);
  EXPECT_NE(rig.camera->model.cx, lens.cx) << "the landmarks' pictures improve the lens";
}

TEST(CalibrationSession, KeepsASurfaceThatTheRigHas) {
  const sim::config::WorldFile file = sim::config::reference_world();
  sim::Simulator world(file, 4);
  rig::Rig rig = blank_rig(file);
  rig.surfaces.emplace_back();
  rig.surfaces.back().name = "table";
  rig.surfaces.back().width = 0.8;
  calibration::session::CalibrationPlan plan = quick_beginning();
  calibration::session::SessionHooks hooks;
  hooks.save = [&rig](const rig::Rig&) -> Expected<void> {
    if (rig.surface("wall") != nullptr) return refused("far enough");
    return {};
  };
  const auto session = calibration::session::calibrate_rig(laboratory_of(world), rig, plan, hooks);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().message, "far enough");
  ASSERT_EQ(rig.surfaces.size(), 2u);
  EXPECT_EQ(rig.surface("table")->width, 0.8);
  EXPECT_NEAR(rig.surface("wall")->width, 0.75, 0.01);
}

// Does what the simulated person does, until a landmark at which something else happens.
class PersonWhoStops : public device::Person {
 public:
  PersonWhoStops(device::Person& person, int at, ErrorCode why) : person_(person), at_(at), why_(why) {}
  Expected<void> ask(const device::Request& request) override {
    if (request.what == "landmark" && request.index >= at_) return refused(why_, "not this landmark");
    return person_.ask(request);
  }
  Expected<bool> ready() override { return person_.ready(); }

 private:
  device::Person& person_;
  int at_;
  ErrorCode why_;
};

struct Landmarks {
  std::size_t found = 0;
  std::string message;
};

// Up to the landmarks, of which the laboratory has more than the person gets to.
Landmarks landmarks_until(int at, ErrorCode why) {
  const sim::config::WorldFile file = sim::config::reference_world();
  sim::Simulator world(file, 4);
  rig::Rig rig = blank_rig(file);
  calibration::session::CalibrationPlan plan = quick_beginning();
  auto laboratory = laboratory_of(world);
  PersonWhoStops person(laboratory.person, at, why);
  calibration::session::AcquisitionContext context{laboratory.clock, laboratory.arm, laboratory.tracker,
                                                   laboratory.camera, person};
  calibration::session::SessionHooks hooks;
  hooks.save = [&rig](const rig::Rig&) -> Expected<void> {
    if (!rig.landmarks.empty()) return refused("far enough");
    return {};
  };
  const auto session = calibration::session::calibrate_rig(context, rig, plan, hooks);
  return {rig.landmarks.size(), session ? std::string() : session.error().message};
}

TEST(CalibrationSession, LandmarksEndOnlyWhereThePersonSaysSo) {
  const auto all = sim::Simulator(sim::config::reference_world(), 4).truth().landmarks.size();
  ASSERT_GT(all, 5u);
  EXPECT_EQ(landmarks_until(5, ErrorCode::no_more).found, 5u);
  // Any other failure ends the session instead of leaving the others out in silence.
  for (const ErrorCode why : {ErrorCode::timed_out, ErrorCode::disconnected, ErrorCode::unspecified}) {
    const Landmarks stopped = landmarks_until(5, why);
    EXPECT_EQ(stopped.found, 0u);
    EXPECT_NE(stopped.message.find("not this landmark"), std::string::npos) << stopped.message;
  }
  EXPECT_EQ(landmarks_until(2, ErrorCode::no_more).found, 0u) << "two are too few";
}

}  // namespace
}  // namespace palpate::evaluation
