// The graphics server as a process: camera and tracker from the laboratory's channel, or a real camera and a
// tracker over OpenIGTLink, and no laboratory; states over ZeroMQ, a picture per image; a person, or in demos
// the scripted player, sits in front of it. With a window: main thread alone.
// What a person should know while it runs is in the log, of the part "graphics".
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/desktop/spectator_window.h"
#include "palpate/record/session/recorded_drivers.h"
#include "palpate/server/graphics/pose_feed.h"
#include "palpate/server/session/graphics_setup.h"
#include "palpate/server/session/physics_meeting.h"
#include "palpate/transport/server_place.h"

namespace palpate::server::session {

struct GraphicsProcessOptions : GraphicsSetup {
  transport::ServerName server;
  std::vector<graphics::PublishAt> publish;  // poses for 3D Slicer and others
  std::filesystem::path mesh;  // what touch shows, where it lies elsewhere than on the server's machine
  bool window = false;         // on this machine's display, with sound
  std::optional<desktop::MonitorView> monitor;  // a second window, for those who look on; with `window`
  bool biocular = false;  // in the window: the camera's picture before both eyes, side by side
  bool headset = false;   // in the headset of this machine's OpenXR runtime (palpate/headset/headset.h)
  std::optional<double> headset_distance;  // m, of the picture there; none: that of the stylus' tip
  // Shows the timecode, on the simulated display or, where the camera is a real one, in the window, and
  // measures the delay from light to light with it.
  bool timecode = false;
  // 0 = until asked to stop, or the window is closed. A person in front of the window is not cut short.
  double seconds = 0.0;
  double wait_s = kPatienceForPhysicsS;  // for the physics server's first answer
  // Shows this machine's clock with an offset and a drift, so that the synchronisation has something to find.
  double disguise_offset_s = 0.0, disguise_drift_ppm = 0.0;
  std::filesystem::path
      out;  // realtime_frames.csv, realtime_sync.csv, realtime_poses.csv; with a headset its poses; empty = none
  std::string rig_text;  // the rig's file as it was read, for the recording; empty: a text is made of the rig
  std::filesystem::path record;                       // a new file for a recording; empty: none
  record::session::PictureRecording record_pictures;  // of its cameras, in there
  std::filesystem::path trace;  // of where each frame's time goes, for Perfetto (frame_trace.h); empty: none
  std::function<void()> ready;  // called once, when its pictures begin
};

Expected<Json> run_graphics_process(const GraphicsProcessOptions& options);

}  // namespace palpate::server::session
