// The mouse as the hand that holds the stylus: where the pointer lies in the picture becomes a place in the
// world, for a HandDevice.
//
// The origin of the body that the stylus carries follows the pointer on a plane that leans away from the
// person, so that pushing the mouse forward pushes it forward and up, as a stroke does; the wheel moves that
// plane along `wheel`. Buttons turn it about `up` while they are held. Because the pointer's ray goes through
// the camera as it stands now, it stays under the pointer while the head moves.
//
// What faces nothing is a stylus that stands, and touches. A pointer that rests holds it still in the world, however
// the head moves; one that moves takes it along by as much as it moves in the picture, and where the head has moved
// the two apart, every move brings them together again a little. Where there is a surface to explore, the tip is led
// over it, a little above, and the wheel leads it up and down along the surface's normal; the left button presses
// it in, the right one lifts it off.
//
// Speed and acceleration are bounded like a hand's; what is out of reach becomes the nearest place on the way there
// that is not. World frame, SI. Pure, deterministic; one thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "palpate/desktop/pointed_surface.h"
#include "palpate/device/camera_model.h"
#include "palpate/device/devices.h"

namespace palpate::desktop {

struct MouseHandSettings {
  Vector3 home = Vector3::Zero();  // of the carried body; must be within reach
  // Right handed, unit: as the person sees them.
  Vector3 right = Vector3::UnitX(), up = Vector3::UnitY(), forward = -Vector3::UnitZ();
  double lean = 0.6;                  // rad, of the plane from upright; pi/2: it lies flat
  Vector3 wheel = -Vector3::UnitZ();  // unit: where the wheel, turned away from the person, leads
  double notch = 0.015;               // m for a notch of the wheel
  double farthest = 0.10;             // m the wheel leads away from home, either way
  Vector3 offset{0.0, 0.0, -0.09};    // of the carried body's origin in Tip
  std::optional<Vector3> faces;       // its +y looks there, raised by `raised`; none: the stylus stands
  double raised = 0.25;               // slope of the face
  double handle_tilt = -0.6;          // rad about the face's normal: as a right hand holds it
  double twist = 0.45;                // rad while a button is held
  double max_acceleration = 30.0, max_speed = 2.0;    // m/s^2, m/s
  std::function<bool(const Vector3& tip)> reachable;  // none: everywhere
  // Of a stylus that stands: how far it leans from upright towards the person, rad, and what it explores, if anything.
  double stylus_lean = 0.0;
  std::shared_ptr<const PointedSurface> surface;
};

class MouseHand {
 public:
  MouseHand(const device::CameraModel& camera, const MouseHandSettings& settings);

  void point(const device::Pixel& pixel);  // in the undistorted picture
  void roll(double notches);               // of the wheel, away from the person positive
  void hold_buttons(bool left, bool right) { left_ = left, right_ = right; }
  void see(const Pose<World, CameraOptical>& X_world_camera);
  // The pointer is over another camera's picture from now on.
  void look_through(const device::CameraModel& camera) { camera_ = camera; }
  // The hand is there now: the way goes on from there (somebody else has moved it until now), and so does its
  // turn.
  void take_over(const device::HandTarget& at, double t);

  // Where the stylus should be at `t`, s of any steady clock. Call often.
  device::HandTarget act(double t);

  // From the eye through the pointer, World, unit; straight ahead while nobody points.
  Vector3 ray() const;
  // Where the carried body is wanted, before the hand's own inertia; for the picture and for tests.
  Vector3 wanted() const;

 private:
  // What the pointer means in the world.
  struct Aim {
    Vector3 eye, along;                          // the ray
    std::optional<PointedSurface::Place> place;  // where it meets what is explored, or what that stands on
  };
  Quaternion stylus_rotation(const Vector3& carried) const;
  Vector3 middle_of_plane() const { return settings_.home + depth_ * settings_.wheel; }
  std::optional<Vector3> on_plane(const Aim& aim) const;
  Vector3 over_surface(const PointedSurface::Place& place) const;
  Vector3 over_all(const Vector3& goal, const Vector3& tip) const;
  Vector3 pointed_at() const;
  device::Pixel followed(const device::Pixel& pixel) const;
  void aim_at(const device::Pixel& pixel);
  double wanted_height() const;

  device::CameraModel camera_;
  MouseHandSettings settings_;
  std::optional<device::Pixel> pointer_;
  std::optional<Pose<World, CameraOptical>> X_world_camera_;
  std::optional<Aim> aim_;  // of a stylus that stands, as of the pointer's last move
  double depth_ = 0.0, twist_ = 0.0;
  double rolled_, height_;  // m, of the tip's lowest place over what is explored: by the wheel; now
  Quaternion left_over_ = Quaternion::Identity();  // of the turn in which it was taken over, World
  bool left_ = false, right_ = false;
  std::optional<double> last_;
  Vector3 position_, velocity_ = Vector3::Zero();  // of the carried body
};

}  // namespace palpate::desktop
