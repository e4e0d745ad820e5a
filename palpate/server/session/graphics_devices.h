// The devices of a graphics server, opened as its options say: cameras and tracker of their own drivers, and
// the simulated laboratory's for what nobody names.
//
// One object, one thread. Errors: what a driver says, with what to do about it; cameras that are named are
// opened first, so that who names one hears of it before a laboratory is missed.
#pragma once

#include <memory>

#include "drivers/cameras/live_camera.h"
#include "drivers/laboratory/channel.h"
#include "drivers/openigtlink/tracker_device.h"
#include "palpate/core/expected.h"
#include "palpate/device/devices.h"
#include "palpate/server/session/graphics_process.h"

namespace palpate::server::session {

class GraphicsDevices {
 public:
  static Expected<GraphicsDevices> open(const GraphicsProcessOptions& options);

  device::TrackerDevice& tracker() const;
  device::CameraDevice& camera() const;
  device::CameraDevice* right_camera() const;  // null: there is none
  // The right camera's stamps are by the left one's clock.
  bool one_clock() const;
  device::HandDevice* hand() const { return hand_.get(); }  // null: nobody leads it from here

  // Null where nothing of it is used.
  const std::shared_ptr<drivers::laboratory::LabClient>& laboratory() const { return laboratory_; }
  // Null where the laboratory's stands in.
  drivers::cameras::LiveCamera* live_camera() const { return live_camera_.get(); }
  const drivers::cameras::LiveCamera* live_right() const { return live_right_.get(); }
  const drivers::openigtlink::OpenIgtlinkTracker* live_tracker() const { return live_tracker_.get(); }

 private:
  GraphicsDevices() = default;
  Expected<void> open_live_cameras(const GraphicsProcessOptions& options);
  Expected<void> open_laboratory(const GraphicsProcessOptions& options);
  Expected<void> open_tracker(const GraphicsProcessOptions& options);
  Expected<void> open_laboratory_cameras(const GraphicsProcessOptions& options);

  std::shared_ptr<drivers::laboratory::LabClient> laboratory_;
  std::unique_ptr<drivers::cameras::LiveCamera> live_camera_, live_right_;
  std::unique_ptr<drivers::laboratory::LabCamera> lab_camera_, lab_right_;
  std::unique_ptr<drivers::openigtlink::OpenIgtlinkTracker> live_tracker_;
  std::unique_ptr<device::TrackerDevice> other_tracker_;
  std::unique_ptr<drivers::laboratory::LabHand> hand_;
  bool live_right_by_own_clock_ = false;
};

}  // namespace palpate::server::session
