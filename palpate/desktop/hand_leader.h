// Leads the hand as the mouse says, with the strokes that help it, a thousand times a second in a thread of
// its own: drawing a picture takes some 30 ms in software, and a hand that stood still so long and then
// jumped would miss what moves, or be stopped for its speed.
//
// Every call is safe from any thread; a call waits while a step is computed, well under a millisecond. While
// nobody leads (let_go) the device is not touched and may be moved by another. Errors: none of its own.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "palpate/desktop/mouse_hand.h"
#include "palpate/scene/player.h"
#include "palpate/time/clock.h"
#include "palpate/time/clock_model.h"

namespace palpate::desktop {

class HandLeader {
 public:
  // `help`: null where the application has none.
  HandLeader(MouseHand hand, std::unique_ptr<scene::InputAssist> assist);
  ~HandLeader();  // the thread ends
  HandLeader(const HandLeader&) = delete;
  HandLeader& operator=(const HandLeader&) = delete;

  // Starts the thread; both must outlive this object.
  void start(device::HandDevice& device, const MonotonicClock<GraphicsClock>& clock);

  // The mouse. `pixel`: in the undistorted picture of that camera, which stands at that pose.
  void point(const device::Pixel& pixel);
  void roll(double notches);
  void hold_buttons(bool left, bool right);
  void look_through(const device::CameraModel& camera, const Pose<World, CameraOptical>& X_world_camera);

  // What the picture shows; and how the physics host's time is known, for the strokes.
  void show(const scene::SceneState& state);
  void synchronised(const ClockModel<GraphicsClock, PhysicsClock>& physics_time);

  // The simulated person's head, on or off; whether it is held still from now on.
  bool turn_head_still();
  // On or off; whether it helps from now on. Nothing where there is none.
  std::optional<bool> turn_help();
  // From here on, until let_go(). Without a place: wherever the mouse has it.
  void take_over(const std::optional<device::HandTarget>& at, Instant<GraphicsClock> now);
  // Where it leaves the hand.
  device::HandTarget let_go(Instant<GraphicsClock> now);

  // Where the hand should be now; what the thread does, for tests.
  device::HandTarget step(Instant<GraphicsClock> now);

 private:
  void run(device::HandDevice& device, MonotonicClock<GraphicsClock> clock);
  device::HandTarget led(Instant<GraphicsClock> now);  // mutex_ held, as below
  device::HandTarget led_by_hand_or_stroke(Instant<GraphicsClock> now);

  std::mutex mutex_;
  MouseHand hand_;
  std::unique_ptr<scene::InputAssist> assist_;
  bool head_still_ = false, helped_ = true, leads_ = false, left_ = false, right_ = false;
  std::optional<Vector3> eye_;  // World; none: it is not known where the picture stands
  std::optional<ClockModel<GraphicsClock, PhysicsClock>> physics_time_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

}  // namespace palpate::desktop
