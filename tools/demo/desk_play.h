// A game on a desk, with a webcam, a printed board and a mouse: arm and physics server as processes beside
// this one, which is the graphics server and holds the window.
//
// The arm is the simulated laboratory's without its pictures, made to fit the rig: it stands where the rig
// says and has no errors of its own. All of it ends with the window. Main thread alone.
#pragma once

#include <filesystem>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/rig/rig.h"
#include "palpate/server/session/graphics_process.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::tools::demo {

// The laboratory whose arm is the rig's to the last digit, over the rig's table; the rest is the reference's.
sim::config::WorldFile desk_world(const rig::Rig& rig);

struct DeskPlayOptions {
  std::filesystem::path program;   // this executable
  std::filesystem::path rig_file;  // that graphics.rig was read from
  std::string application;
  scene::SettingValues settings;  // of the applications
  std::uint64_t seed = 1;         // of the application
  server::session::GraphicsProcessOptions
      graphics;  // rig, camera, window, player, quality, seconds; the rest is set
};

// The graphics server's figures. Refused where a part cannot begin or ends early; what it said last is in the
// message.
Expected<Json> play_at_desk(const DeskPlayOptions& options);

}  // namespace palpate::tools::demo
