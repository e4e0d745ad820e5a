#include "palpate/system/player_seat.h"

#include "palpate/applications/applications.h"
#include "palpate/sim/arm_twin.h"
#include "palpate/sim/hand_twin.h"

namespace palpate {

Reach players_reach(const Rig& rig, const sim::WorldFile& world) {
  Reach reach;
  reach.X_world_base = rig.arm->X_world_base;
  reach.lengths = rig.arm->lengths;
  for (Eigen::Index i = 0; i < 3; ++i) {
    reach.joints[0][i] = world.arm.joint_range[static_cast<std::size_t>(i)][0];
    reach.joints[1][i] = world.arm.joint_range[static_cast<std::size_t>(i)][1];
  }
  return reach;
}

PlayerSettings own_hand(const sim::WorldFile& world) {
  PlayerSettings settings;
  settings.reaction_s = settings.aim_sd = settings.perception_sd = 0.0;
  settings.max_acceleration = world.player.max_hand_acceleration;
  settings.max_speed = kSpeedShare * world.arm.max_speed;
  settings.hand.stiffness = sim::HandTwin::kApproachRate * sim::HandTwin::kSpeedRate;
  settings.hand.damping = sim::HandTwin::kSpeedRate;
  settings.wrist_rate = sim::ArmTwin::kTurnRate;
  return settings;
}

namespace {

PlayerSettings settings_of(const sim::WorldFile& world, std::uint64_t seed, double extra_delay_s) {
  PlayerSettings settings = own_hand(world);
  settings.reaction_s = world.player.reaction_s + extra_delay_s;
  settings.aim_sd = world.player.aim_sd;
  settings.perception_sd = PlayerSettings{}.perception_sd;
  settings.seed = seed;
  return settings;
}

}  // namespace

Expected<PlayerSeat> PlayerSeat::seat(const SceneDescription& scene, const Rig& rig,
                                      const sim::WorldFile& world, std::uint64_t seed, double extra_delay_s) {
  auto player = make_player(scene, players_reach(rig, world), settings_of(world, seed, extra_delay_s));
  if (!player) return tl::unexpected(player.error());
  return PlayerSeat(std::move(*player));
}

void PlayerSeat::show(const FrameRecord& frame, const GraphicsServer& server) {
  if (frame.have_state) player_->show(frame.state, server.sync().model().to(frame.drawn));
}

void PlayerSeat::act(Instant<GraphicsClock> now, const GraphicsServer& server, HandDevice& hand) {
  if (server.sync().exchanges() == 0) return;
  hand.move_to(player_->act(server.sync().model().to(now)));
}

void PlayerSeat::take_over(const HandTarget& at, Instant<GraphicsClock> now, const GraphicsServer& server) {
  if (server.sync().exchanges() > 0) player_->take_over(at, server.sync().model().to(now));
}

}  // namespace palpate
