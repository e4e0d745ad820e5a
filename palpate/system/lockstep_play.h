// World, physics server and graphics server in one process on one virtual clock: a game played in lock-step.
// With both eyes where the world has two cameras and the rig has both calibrated.
//
// Deterministic to the bit for the same world, rig and seed. The three parts meet only over their channels:
// devices, and the in-process twin of the network with seeded delay. Truth is looked at beside the play,
// frame by frame, for the report; no part of it flows back.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "palpate/graphics_server/frame_record.h"
#include "palpate/graphics_server/graphics_server.h"
#include "palpate/graphics_server/photon_meter.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/model/rig.h"
#include "palpate/network/in_process.h"
#include "palpate/scene/application.h"
#include "palpate/sim/sim_world.h"
#include "palpate/system/overlay.h"

namespace palpate {

// What a frame showed, and what was true at the moment it was to show: its image's mid-exposure, or, of a
// predicted picture, when its light leaves the display.
struct PlayedFrame {
  FrameRecord record;  // without pixels
  CameraView truth;
  std::optional<CameraView> right_truth;  // of the second camera, where the record has its pose
  Vector3 true_tip = Vector3::Zero();
};

// A frame as it is passed on, with what the graphics server knew of the exchange then.
struct LockstepFrame {
  const PlayedFrame& played;
  double sync_error_s = 0.0;          // true error of the clock synchronisation
  double sync_uncertainty_s = 0.0;    // as stated
  std::vector<double> round_trips_s;  // virtual, since the frame before
};

struct LockstepOptions {
  double seconds = 30.0;
  double warm_up_s = 2.0;  // clocks settle and the person takes the stylus; nothing is counted
  std::uint64_t seed = 1;
  ChannelModel channel;
  Duration drawing_time = std::chrono::milliseconds(12);  // from an image's arrival to its picture, virtual
  double player_extra_delay_s = 0.0;
  GraphicsSettings graphics;
  Duration extra_force_delay{0};
  // The simulated display shows the clock strip, and the delay from light to light is measured with it.
  bool clock_strip = false;
  // Each camera's clock is found by itself, as if they did not have one in common.
  bool right_camera_own_clock = false;
  // What goes wrong with one of the cameras alone, on its way to the graphics server; beside the world file's
  // faults.
  std::function<void(double, std::optional<CameraImage>&)> disturb_left_camera, disturb_right_camera;
  // Every millisecond, for whoever wants to look at the conditions: with the seconds since the play began,
  // warm-up counted, as the world file's faults count them.
  std::function<void(double, const std::vector<Condition>&)> conditions;
  std::function<void(const WorldState&)> watch;  // each state of the physics loop that counts
  // Where given, frames go here and nothing of them is kept, nor of the haptic loop: a play of any length.
  std::function<void(const LockstepFrame&)> pass_on;
};

// The parts that need pixels. Without them the play runs blind: the tracker's pose alone, nothing drawn.
struct LockstepPictures {
  sim::RenderView camera;  // what the simulated camera sees
  PoseRefiner refiner;
  FramePainter painter;
  StatePredictor predictor;
  std::function<void(const FrameRecord&)> shown;  // each frame with its pixels
};

// The delay of one picture, as measured and as it truly was.
struct MeasuredDelay {
  PhotonDelay measured;
  Duration truth{0};
};

struct LockstepResult {
  std::vector<PlayedFrame> frames;
  std::vector<HapticRecord> haptics;  // 1 kHz, around the blows
  HapticStatistics haptic;
  std::vector<MeasuredDelay> delays;  // of the pictures in whose image a clock strip could be read
  std::uint64_t strips_unread = 0;
  ExchangeCounters exchange;
  WorldState final_state;
  std::vector<double> round_trips_s;  // virtual: the channel model's
  std::vector<double> sync_errors_s;  // true error of the clock synchronisation, each frame
};

// What a world file says of them.
GraphicsSettings graphics_settings(const sim::WorldFile& world);

// Plays on from wherever the world stands. Refused where the rig lacks what a part needs.
Expected<LockstepResult> play_in_lockstep(sim::SimWorld& world, const Rig& rig, const SceneDescription& scene,
                                          const LockstepOptions& options, const LockstepPictures& pictures,
                                          const std::function<void(double)>& progress);

// The tip of the stylus as a state shows it: the bat's pose taken back along its offset.
Vector3 shown_tip(const WorldState& state, const SceneDescription& scene);

}  // namespace palpate
