// The devices of a graphics server, opened as its set-up says: cameras and tracker that are named, and a laboratory's
// for what nobody names.
//
// One object, one thread. Errors: what a driver says, with what to do about it; cameras that are named are
// opened first, so that who names one hears of it before a laboratory is missed.
#pragma once

#include <memory>

#include "palpate/core/expected.h"
#include "palpate/device/opened.h"
#include "palpate/server/session/graphics_setup.h"

namespace palpate::server::session {

class GraphicsDevices {
 public:
  static Expected<GraphicsDevices> open(const GraphicsSetup& setup);

  device::TrackerDevice& tracker() const;
  device::OpenedCamera& camera() const { return *camera_; }
  device::CameraDevice* right_camera() const;  // null: there is none
  // The right camera's stamps are by the left one's clock.
  bool one_clock() const { return one_clock_; }
  device::HandDevice* hand() const { return hand_ ? &hand_->device() : nullptr; }  // null: nobody leads it

  // Null where the laboratory's stands in.
  device::OpenedCamera* live_camera() const { return camera_->simulated() ? nullptr : camera_.get(); }
  const device::OpenedCamera* live_right() const { return right_.get(); }
  const device::OpenedTracker* tracker_driver() const { return tracker_.get(); }  // null: there is no tracker

  // Refused where one of them has gone for good.
  Expected<void> look() const;

 private:
  GraphicsDevices() = default;
  Expected<void> open_named_cameras(const GraphicsSetup& setup);
  Expected<void> open_tracker(const GraphicsSetup& setup);
  Expected<void> open_other_camera(const GraphicsSetup& setup);

  std::unique_ptr<device::OpenedCamera> camera_, right_;
  device::CameraDevice* right_of_pair_ = nullptr;  // camera_'s own
  std::unique_ptr<device::OpenedTracker> tracker_;
  std::unique_ptr<device::TrackerDevice> no_tracker_;
  std::unique_ptr<device::OpenedHand> hand_;
  bool one_clock_ = true;
};

}  // namespace palpate::server::session
