// World, physics server and graphics server in one process on one virtual clock: a game played in lock-step.
//
// Deterministic to the bit for the same world, rig and seed. The three parts meet only over their channels: devices,
// and the in-process twin of the network with seeded delay. Truth is looked at beside the play, frame by frame, for the
// report; no part of it flows back.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "palpate/graphics_server/frame_record.h"
#include "palpate/graphics_server/graphics_server.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/model/rig.h"
#include "palpate/network/in_process.h"
#include "palpate/scene/application.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/sim_world.h"
#include "palpate/system/overlay.h"

namespace palpate {

struct LockstepOptions {
  double seconds = 30.0;
  double warm_up_s = 2.0;   // clocks settle, nothing is counted, no serve
  std::uint64_t seed = 1;
  ChannelModel channel;
  Duration drawing_time = std::chrono::milliseconds(12);  // from an image's arrival to its picture, virtual
  double player_extra_delay_s = 0.0;
};

// What a frame showed, and what was true when its image was taken.
struct PlayedFrame {
  FrameRecord record;  // without pixels
  CameraView truth;
  Vector3 true_tip = Vector3::Zero();
};

struct LockstepResult {
  std::vector<PlayedFrame> frames;
  std::vector<HapticRecord> haptics;  // 1 kHz around the blows
  HapticStatistics haptic;
  ExchangeCounters exchange;
  WorldState final_state;
  std::vector<double> sync_errors_s;  // true error of the clock synchronisation, each frame
};

// Called for each frame with its picture (record.rgb); may keep it.
using FrameSink = std::function<void(const FrameRecord&)>;

// Plays on from wherever the world stands. Errors: refused, where the rig is incomplete or a part gives up.
Expected<LockstepResult> play_in_lockstep(sim::SimWorld& world, sim::CameraRenderer* renderer, const Rig& rig,
                                          const SceneDescription& scene, const LockstepOptions& options,
                                          const FrameSink& sink, const std::function<void(double)>& progress);

}  // namespace palpate
