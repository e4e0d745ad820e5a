#include "palpate/desktop/scripted_user.h"

#include "palpate/sim/simulated_arm.h"
#include "palpate/sim/simulated_hand.h"

namespace palpate::desktop {

scene::Reach players_reach(const rig::Rig& rig, const sim::config::WorldFile& world) {
  scene::Reach reach;
  reach.X_world_base = rig.arm->X_world_base;
  reach.lengths = rig.arm->model.lengths;
  for (Eigen::Index i = 0; i < 3; ++i) {
    reach.joints[0][i] = world.arm.joint_range[static_cast<std::size_t>(i)][0];
    reach.joints[1][i] = world.arm.joint_range[static_cast<std::size_t>(i)][1];
  }
  return reach;
}

scene::PlayerSettings own_hand(const sim::config::WorldFile& world) {
  scene::PlayerSettings settings;
  settings.reaction_s = settings.aim_sd = settings.perception_sd = 0.0;
  settings.max_acceleration = world.player.max_hand_acceleration;
  settings.max_speed = kSpeedShare * world.arm.max_speed;
  settings.hand.stiffness = sim::SimulatedHand::kApproachRate * sim::SimulatedHand::kSpeedRate;
  settings.hand.damping = sim::SimulatedHand::kSpeedRate;
  settings.wrist_rate = sim::SimulatedArm::kTurnRate;
  return settings;
}

namespace {

scene::PlayerSettings settings_of(const sim::config::WorldFile& world, std::uint64_t seed,
                                  double extra_delay_s) {
  scene::PlayerSettings settings = own_hand(world);
  settings.reaction_s = world.player.reaction_s + extra_delay_s;
  settings.aim_sd = world.player.aim_sd;
  settings.perception_sd = scene::PlayerSettings{}.perception_sd;
  settings.seed = seed;
  return settings;
}

}  // namespace

Expected<ScriptedUser> ScriptedUser::make(const scene::ApplicationRegistry& applications,
                                          const scene::SceneDescription& scene, const rig::Rig& rig,
                                          const sim::config::WorldFile& world, std::uint64_t seed,
                                          double extra_delay_s) {
  auto player =
      applications.make_player(scene, players_reach(rig, world), settings_of(world, seed, extra_delay_s));
  if (!player) return tl::unexpected(player.error());
  return ScriptedUser(std::move(*player));
}

void ScriptedUser::show(const server::graphics::FrameRecord& frame,
                        const server::graphics::GraphicsServer& server) {
  if (frame.have_state) player_->show(frame.state, server.sync().model().to(frame.drawn));
}

void ScriptedUser::act(Instant<GraphicsClock> now, const server::graphics::GraphicsServer& server,
                       device::HandDevice& hand) {
  if (server.sync().exchanges() == 0) return;
  hand.move_to(player_->act(server.sync().model().to(now)));
}

void ScriptedUser::take_over(const device::HandTarget& at, Instant<GraphicsClock> now,
                             const server::graphics::GraphicsServer& server) {
  if (server.sync().exchanges() > 0) player_->take_over(at, server.sync().model().to(now));
}

}  // namespace palpate::desktop
