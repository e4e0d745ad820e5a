// World, physics server and graphics server in one process on one virtual clock: a game played in lock-step.
// With both eyes where the world has two cameras and the rig has both calibrated.
//
// Deterministic to the bit for the same world, rig and seed. The three parts meet only over their channels:
// devices, and the in-process transport of the network with seeded delay. Truth is looked at beside the play,
// frame by frame, for the report; no part of it flows back.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "palpate/evaluation/latency_meter.h"
#include "palpate/evaluation/played_frame.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/server/graphics/frame_record.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/sim/simulator.h"
#include "palpate/transport/in_process.h"

namespace palpate::sim::lockstep {

// A frame as it is passed on, with what the graphics server knew of the exchange then.
struct LockstepFrame {
  const evaluation::PlayedFrame& played;
  double sync_error_s = 0.0;          // true error of the clock synchronisation
  double sync_uncertainty_s = 0.0;    // as stated
  std::vector<double> round_trips_s;  // virtual, since the frame before
};

struct LockstepOptions {
  scene::ApplicationRegistry applications;
  double seconds = 30.0;
  double warm_up_s = 2.0;  // clocks settle and the person takes the stylus; nothing is counted
  std::uint64_t seed = 1;
  transport::ChannelModel channel;
  Duration drawing_time = std::chrono::milliseconds(12);  // from an image's arrival to its picture, virtual
  double player_extra_delay_s = 0.0;
  server::graphics::GraphicsSettings graphics;
  Duration extra_force_delay{0};
  // The simulated display shows the timecode, and the delay from light to light is measured with it.
  bool timecode = false;
  // Each camera's clock is found by itself, as if they did not have one in common.
  bool right_camera_own_clock = false;
  // What goes wrong with one of the cameras alone, on its way to the graphics server; beside the world file's
  // faults.
  std::function<void(double, std::optional<device::CameraImage>&)> disturb_left_camera, disturb_right_camera;
  // Every millisecond, for whoever wants to look at the conditions: with the seconds since the play began,
  // warm-up counted, as the world file's faults count them.
  std::function<void(double, const std::vector<server::graphics::Condition>&)> conditions;
  std::function<void(const scene::SceneState&)> watch;  // each state of the physics loop that counts
  // Where given, frames go here and nothing of them is kept, nor of the haptic loop: a play of any length.
  std::function<void(const LockstepFrame&)> pass_on;
  // A new file for all ticks and states that count (docs/recording.md); empty: nothing is recorded.
  std::filesystem::path record;
};

// The parts that need pixels. Without them the play runs blind: the tracker's pose alone, nothing drawn.
struct LockstepPictures {
  RenderView camera;  // what the simulated camera sees
  server::graphics::FramePipeline* pipeline = nullptr;
  std::function<void(const server::graphics::FrameRecord&)> shown;  // each frame with its pixels
};

// The delay of one picture, as measured and as it truly was.
struct MeasuredDelay {
  evaluation::LatencySample measured;
  Duration truth{0};
};

struct LockstepResult {
  std::vector<evaluation::PlayedFrame> frames;
  std::vector<haptics::HapticRecord> haptics;  // 1 kHz, around the impacts
  haptics::HapticStatistics haptic;
  std::vector<MeasuredDelay> delays;  // of the pictures in whose image a timecode could be read
  std::uint64_t timecodes_unread = 0;
  transport::ExchangeCounters exchange;
  scene::SceneState final_state;
  std::vector<double> round_trips_s;  // virtual: the channel model's
  std::vector<double> sync_errors_s;  // true error of the clock synchronisation, each frame
  std::vector<server::graphics::PredictionError>
      predictions;  // of predicted pictures, as the servers know by themselves
};

// What a world file says of them.
server::graphics::GraphicsSettings graphics_settings(const config::WorldFile& world);

// Plays on from wherever the world stands. Refused where the rig lacks what a part needs, and where its recording cannot be
// written.
Expected<LockstepResult> play_in_lockstep(Simulator& world, const rig::Rig& rig,
                                          const scene::SceneDescription& scene,
                                          const LockstepOptions& options, const LockstepPictures& pictures,
                                          const std::function<void(double)>& progress);

}  // namespace palpate::sim::lockstep
