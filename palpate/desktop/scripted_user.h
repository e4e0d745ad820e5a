// The scripted player in front of the picture: sees frames as they are shown, says where the hand should be.
//
// The only way from picture to hand in demos and tests; a person with a real arm takes its place. Times go
// through the graphics server's clock synchronisation, as everything there. One thread.
#pragma once

#include <memory>

#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::desktop {

// Of the speed at which the arm's motors switch off: what a player, or a mouse, asks of the hand at most.
inline constexpr double kSpeedShare = 0.73;

// Where the tip can be, as the rig knows the arm.
scene::Reach players_reach(const rig::Rig& rig, const sim::config::WorldFile& world);

// How a player's hand follows a target, and what is asked of it at most: what a player knows from having one.
// It sees at once and aims exactly.
scene::PlayerSettings own_hand(const sim::config::WorldFile& world);

class ScriptedUser {
 public:
  // Makes the scripted player of the scene's application. Refused where that has none, is not among
  // `applications`, or the scene lacks what it needs.
  static Expected<ScriptedUser> make(const scene::ApplicationRegistry& applications,
                                     const scene::SceneDescription& scene, const rig::Rig& rig,
                                     const sim::config::WorldFile& world, std::uint64_t seed,
                                     double extra_delay_s = 0.0);

  // A frame has been shown.
  void show(const server::graphics::FrameRecord& frame, const server::graphics::GraphicsServer& server);
  // Leads the hand; call every millisecond or so.
  void act(Instant<GraphicsClock> now, const server::graphics::GraphicsServer& server,
           device::HandDevice& hand);
  // A person has led the hand and leaves it there. No frames need be shown while a person leads it.
  void take_over(const device::HandTarget& at, Instant<GraphicsClock> now,
                 const server::graphics::GraphicsServer& server);

 private:
  explicit ScriptedUser(std::unique_ptr<scene::Player> player) : player_(std::move(player)) {}
  std::unique_ptr<scene::Player> player_;
};

}  // namespace palpate::desktop
