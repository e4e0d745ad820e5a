// The scripted player in front of the picture: sees frames as they are shown, says where the hand should be.
//
// The only way from picture to hand in demos and tests; a person with a real arm takes its place. Times go
// through the graphics server's clock synchronisation, as everything there. One thread.
#pragma once

#include <memory>

#include "palpate/core/expected.h"
#include "palpate/devices/player.h"
#include "palpate/graphics_server/graphics_server.h"
#include "palpate/model/rig.h"
#include "palpate/model/world_file.h"

namespace palpate {

// Of the speed at which the arm's motors switch off: what a player, or a mouse, asks of the hand at most.
inline constexpr double kSpeedShare = 0.73;

// Where the tip can be, as the rig knows the arm.
Reach players_reach(const Rig& rig, const sim::WorldFile& world);

// How a player's hand follows a target, and what is asked of it at most: what a player knows from having one.
// It sees at once and aims exactly.
PlayerSettings own_hand(const sim::WorldFile& world);

class PlayerSeat {
 public:
  // Seats the scripted player of the scene's application. Refused where the scene lacks what that needs.
  static Expected<PlayerSeat> seat(const SceneDescription& scene, const Rig& rig, const sim::WorldFile& world,
                                   std::uint64_t seed, double extra_delay_s = 0.0);

  // A frame has been shown.
  void show(const FrameRecord& frame, const GraphicsServer& server);
  // Leads the hand; call every millisecond or so.
  void act(Instant<GraphicsClock> now, const GraphicsServer& server, HandDevice& hand);
  // A person has led the hand and leaves it there. No frames need be shown while a person leads it.
  void take_over(const HandTarget& at, Instant<GraphicsClock> now, const GraphicsServer& server);

 private:
  explicit PlayerSeat(std::unique_ptr<Player> player) : player_(std::move(player)) {}
  std::unique_ptr<Player> player_;
};

}  // namespace palpate
