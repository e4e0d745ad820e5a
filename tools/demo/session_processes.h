// A session of three processes as a value - simulated laboratory, physics server, graphics server - and the command lines
// that start them. Who starts one fills this in and knows no option of the command line; this is the one place that
// writes them.
//
// Pure functions. What is left at its default is left out, but for what all three must agree on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpate/desktop/spectator_window.h"
#include "palpate/render/compositor.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/transport/server_place.h"

namespace palpate::tools::demo {

struct LaboratoryProcess {
  double seconds = 0.0;             // then it ends, should nobody be left to stop it
  std::filesystem::path exposures;  // file for when its images were taken; empty: none
  bool arm_only = false;            // draws no pictures
};

struct PhysicsServerProcess {
  std::string application;
  std::optional<double> pause_s;  // between two rounds, for people
  transport::ServerName listen;   // where it serves
  std::filesystem::path record;   // new file of its recording; empty: none
};

struct GraphicsServerProcess {
  transport::ServerName connect;
  std::optional<render::Quality> quality;  // none: by what is missed
  bool player = false;
  double seconds = 0.0;
  sim::config::ClockSettings clock;  // what its clock is disguised with
  bool timecode = false;
  bool window = false;  // and the mouse in it
  std::optional<desktop::MonitorView> monitor;
  bool headset = false;
  std::filesystem::path record;  // new file of its recording; empty: none
  std::string pictures;          // in there: jpeg, lossless; empty: none
};

struct SessionProcesses {
  std::string name;  // of the laboratory
  std::filesystem::path rig, world;
  std::uint64_t seed = 1;
  std::filesystem::path out;  // the servers' raw files; empty: none
  LaboratoryProcess laboratory;
  PhysicsServerProcess physics;
  GraphicsServerProcess graphics;
};

// What follows the program's name.
std::vector<std::string> laboratory_arguments(const SessionProcesses& session);
std::vector<std::string> physics_arguments(const SessionProcesses& session);
std::vector<std::string> graphics_arguments(const SessionProcesses& session);

}  // namespace palpate::tools::demo
