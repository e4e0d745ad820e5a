// What a graphics side is made of (graphics_side.h). Values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "palpate/device/driver_registry.h"
#include "palpate/render/compositor.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::server::session {

// What becomes of the camera's pixels.
enum class Pixels : std::uint8_t {
  drawn,   // they are looked at, and each frame is drawn; needs OpenGL
  unseen,  // nobody looks and nothing is drawn (graphics::NullFramePipeline); poses are the tracker's alone
};

struct GraphicsSetup {
  rig::Rig rig;
  // Those that it can draw and play; of another its bodies are shown (scene/generic_view.h).
  scene::ApplicationRegistry applications;
  sim::config::WorldFile world;  // how the player's own arm feels
  device::DriverRegistry drivers;
  // The laboratory that stands in for every device which is not named.
  std::string stand_in = "lab";
  // Instead of the laboratory's; a rig with a board has none.
  std::optional<device::TrackerRequest> tracker;
  // A real one, or a recording, set to the size of the rig's calibration; a second one beside it. The
  // laboratory's are taken where none is named.
  std::optional<device::CameraRequest> camera, right_camera;
  bool right_camera_own_clock =
      false;  // each camera's clock is found by itself, also where they have one in common
  graphics::GraphicsSettings graphics;
  Pixels pixels = Pixels::drawn;
  // Of the picture; none: chosen from what is missed (quality_choice.h).
  std::optional<render::Quality> quality = render::Quality::medium;
  // That holds the stylus and is seen there: virtual things behind it are not drawn over it.
  device::HoldingHand hand = device::HoldingHand::none;
  // Who holds the stylus: the scripted player, a mouse; with both, the mouse from its first movement on.
  bool player = false, mouse = false;
  std::uint64_t seed = 1;             // of the player
  double player_extra_delay_s = 0.0;  // it sees everything so much later
};

}  // namespace palpate::server::session
