// The simulated laboratory: one owner of everything true, and of time.
//
// advance_to moves arm, hand and head on, lets tracker and camera take their frames, and never goes back. The
// devices are those of devices.h and show only what real ones show. What `truth...` and `true_...` return is
// for tests, `world sample` and the report. Everything is the same to the bit for the same file, seed and
// calls. One thread; the devices hold references and live as long as the world does.
#pragma once

#include <memory>

#include "palpate/device/devices.h"
#include "palpate/device/person.h"
#include "palpate/sim/config/world_file.h"
#include "palpate/sim/device_clock.h"
#include "palpate/sim/simulated_camera.h"
#include "palpate/sim/true_view.h"
#include "palpate/sim/truth.h"
#include "palpate/time/clock.h"

namespace palpate::sim {

struct TrueState {  // at one moment
  Pose<World, Tip> X_world_tip;
  Vector3 tip_velocity = Vector3::Zero();
  Pose<World, TipMarker> X_world_tip_marker;
  Pose<World, CameraOptical> X_world_camera;
  Pose<World, CameraMarker> X_world_camera_marker;
  std::optional<Pose<World, Pointer>> X_world_pointer;
  Vector3 theta = Vector3::Zero(), gimbal = Vector3::Zero();
  Vector3 motor_force = Vector3::Zero();  // N, World
};

class Simulator {
 public:
  // The same laboratory on another `visit`: what is true of it stays, the tracker's systematic error included;
  // noise, the hand's misses and the person's choices are drawn anew.
  Simulator(config::WorldFile file, std::uint64_t seed, std::uint64_t visit = 0);
  ~Simulator();
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  Instant<TrueTime> now() const;
  // Times gone by are ignored.
  void advance_to(Instant<TrueTime> t);

  device::ArmDevice& arm();
  device::TrackerDevice& tracker();
  device::CameraDevice& camera();
  // The second camera, which takes its images at the same moments by the same clock; null where the world has
  // one.
  device::CameraDevice* right_camera();
  device::HandDevice& hand();
  device::Person& person();
  // The physics host's clock; sleeping on it moves the world.
  Clock<PhysicsClock>& physics_clock();
  // From now on somebody plays: what the world file says of that time (covered and moved landmarks) holds.
  void begin_play();
  // From here on, both cameras: fewer pictures where nobody needs as many. More than 0.
  void set_camera_rate(double rate_hz);
  // Without a renderer the cameras' images have stamps but no pixels.
  void set_renderer(RenderView render);
  // Instead of camera().poll(), where the picture is to be drawn elsewhere, and shown from its arrival on.
  std::optional<CameraShot> take_shot();
  std::optional<CameraShot> take_right_shot();

  const config::WorldFile& file() const;
  std::uint64_t seed() const;
  const Truth& truth() const;
  TrueState true_state() const;
  TrueView true_view() const;
  // The head's path is a function of time, known also for moments just gone by.
  Pose<World, CameraOptical> true_camera_at(Instant<TrueTime> t) const;
  bool board_in_place() const;

  // True readings of the clocks.
  const DeviceClock<ArmClock>& arm_clock() const;
  const DeviceClock<TrackerClock>& tracker_clock() const;
  const DeviceClock<CameraClock>& camera_clock() const;
  const DeviceClock<GraphicsClock>& graphics_clock() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate::sim
