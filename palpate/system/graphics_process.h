// The graphics server as a process: camera and tracker from the laboratory's channel, or the tracker over
// OpenIGTLink; states over ZeroMQ, a picture per image; in demos the scripted player sits in front of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "palpate/compositor/compositor.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/model/rig.h"
#include "palpate/model/world_file.h"
#include "palpate/network/server_place.h"
#include "palpate/system/live_tracker.h"

namespace palpate {

struct GraphicsProcessOptions {
  Rig rig;
  sim::WorldFile world;  // how the player's own arm feels
  std::string lab = "lab";
  ServerName server;
  std::optional<LiveTracker> tracker;    // instead of the laboratory's
  std::optional<igtl::Address> publish;  // poses for 3D Slicer and others (pose_feed.h)
  Quality quality = Quality::medium;     // of the picture
  bool player = false;                   // the scripted player holds the stylus
  std::uint64_t seed = 1;
  double seconds = 0.0;  // 0 = until asked to stop
  // Shows this machine's clock with an offset and a drift, so that the synchronisation has something to find.
  double disguise_offset_s = 0.0, disguise_drift_ppm = 0.0;
  std::filesystem::path out;                       // realtime_frames.csv and realtime_sync.csv; empty = none
  std::function<void(const std::string&)> notice;  // what a person should know while it runs, a line each
};

Expected<Json> run_graphics_process(const GraphicsProcessOptions& options);

}  // namespace palpate
