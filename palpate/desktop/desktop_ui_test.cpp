#include "palpate/desktop/desktop_ui.h"

#include <gtest/gtest.h>

#include <deque>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/specification.h"
#include "applications/touch/specification.h"
#include "palpate/math/looking.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/head_motion.h"
#include "palpate/sim/truth_rig.h"

namespace palpate::desktop {
namespace {

scene::ApplicationRegistry both() {
  return {applications::pingpong::specification(), applications::touch::specification()};
}

scene::SceneDescription scene_of(const sim::Simulator& world, const rig::Rig& rig,
                                 const std::string& application) {
  return server::physics::scene_from_rig(rig, *sim::config::scene_of(world.file(), both(), application));
}

TEST(MouseHandOfARig, BeginsWithinReachAndStaysThereWhereverThePointerGoes) {
  for (const std::string application : {"pingpong", "touch"}) {
    sim::Simulator world(sim::config::reference_world(), 3);
    const rig::Rig rig = sim::truth_rig(world);
    const auto settings = mouse_hand_settings(scene_of(world, rig, application), both().handling(application),
                                              rig, world.file());
    MouseHand hand(rig.camera->model, settings);
    EXPECT_TRUE(settings.reachable(hand.act(0.0).tip.m)) << application;
    hand.see(looking(world.file().head.eye, world.file().head.look_at));
    double t = 0.0;
    for (const device::Pixel& pixel :
         {device::Pixel(0, 0), device::Pixel(639, 479), device::Pixel(320, 100), device::Pixel(0, 479)}) {
      hand.point(pixel);
      for (int i = 0; i < 300; ++i) hand.act(t += 0.01);
      EXPECT_TRUE(settings.reachable(hand.act(t).tip.m)) << application << ' ' << pixel.transpose();
    }
  }
}

// Somebody who follows the ball's picture with the mouse: sees each picture 150 ms late, points ahead of the
// ball by as much as it moves on meanwhile. No stroke: the bat is held against the ball.
class Follower {
 public:
  Follower(const device::CameraModel& camera, const Pose<World, CameraOptical>& X) : camera_(camera), X_(X) {}
  void see(double t, const Vector3& ball, bool incoming) { waiting_.push_back({t + 0.15, ball, incoming}); }
  // Where the pointer should be.
  std::optional<device::Pixel> act(double t) {
    while (!waiting_.empty() && waiting_.front().ready <= t) {
      before_ = last_;
      last_ = waiting_.front();
      waiting_.pop_front();
    }
    if (!last_ || !before_ || !last_->incoming) return std::nullopt;
    const double gap = last_->ready - before_->ready;
    const device::Pixel a = pixel(before_->ball), b = pixel(last_->ball);
    if (gap <= 0.0 || (b - a).norm() > 120.0) return std::nullopt;
    return b + (b - a) / gap * kAhead_s;
  }

 private:
  static constexpr double kAhead_s = 0.20;
  struct Seen {
    double ready = 0.0;
    Vector3 ball = Vector3::Zero();
    bool incoming = false;
  };
  device::Pixel pixel(const Vector3& p) const {
    return camera_.project_undistorted((X_.inverse() * Point<World>{p}).m);
  }
  device::CameraModel camera_;
  Pose<World, CameraOptical> X_;
  std::deque<Seen> waiting_;
  std::optional<Seen> before_, last_;
};

TEST(MouseHandOfARig, LetsSomebodyPlayWhoOnlyFollowsTheBallWithThePointer) {
  sim::Simulator world(sim::config::reference_world(), 3);
  const rig::Rig rig = sim::truth_rig(world);
  const auto scene = scene_of(world, rig, "pingpong");
  auto application = both().make_physics(scene, {.seed = 1, .pause_s = 0.3});
  ASSERT_TRUE(application) << application.error().message;
  server::physics::PhysicsServer physics(
      rig, scene, std::move(*application), world.arm(),
      haptics::HapticSettings{.permit = haptics::ForcePermit::of_simulated_arm()});
  const auto X_world_camera = looking(world.file().head.eye, world.file().head.look_at);
  MouseHand hand(rig.camera->model,
                 mouse_hand_settings(scene, both().handling("pingpong"), rig, world.file()));
  hand.see(X_world_camera);
  Follower person(rig.camera->model, X_world_camera);
  const auto start = world.now();
  for (int ms = 1; ms <= 60'000; ++ms) {
    const double t = 1e-3 * ms;
    world.advance_to(start + std::chrono::milliseconds(ms));
    const Instant<PhysicsClock> now{world.now().since_epoch};
    physics.haptic_tick(now);
    physics.physics_tick(now);
    const scene::SceneState& state = physics.newest();
    if (ms % 33 == 0)
      person.see(t, state.bodies[applications::pingpong::kBall].p(),
                 state.counters[applications::pingpong::kPhase] ==
                     static_cast<std::int32_t>(applications::pingpong::Phase::incoming));
    if (const auto pointer = person.act(t)) hand.point(*pointer);
    world.hand().move_to(hand.act(t));
  }
  const auto& counters = physics.newest().counters;
  RecordProperty("serves", counters[applications::pingpong::kServes]);
  RecordProperty("returned", counters[applications::pingpong::kReturned]);
  EXPECT_GE(counters[applications::pingpong::kServes], 15);
  // Eighteen of twenty-five came back when this was written.
  EXPECT_GE(counters[applications::pingpong::kReturned], 0.5 * counters[applications::pingpong::kServes]);
}

}  // namespace
}  // namespace palpate::desktop
