#include "palpate/server/session/graphics_devices.h"

#include <utility>

namespace palpate::server::session {
namespace {

// The server of a rig with a board asks nobody: the picture says where the camera is.
class NoTracker : public device::TrackerDevice {
 public:
  std::vector<device::TrackerSample> poll() override { return {}; }
};

// Opens it and puts it into its place.
template <typename Request, typename Opened>
Expected<void> open_into(std::unique_ptr<Opened>& place, const device::DriverRegistry& drivers,
                         const Request& request) {
  auto opened = drivers.open(request);
  if (!opened) return tl::unexpected(opened.error());
  place = std::move(*opened);
  return {};
}

// Set to the size that was calibrated.
device::CameraRequest sized(device::CameraRequest request, const rig::CameraCalibration& calibrated) {
  request.settings.width = calibrated.model.width;
  request.settings.height = calibrated.model.height;
  return request;
}

template <typename Opened>
Expected<void> look_at(const std::unique_ptr<Opened>& device) {
  if (!device) return {};
  if (auto there = device->look(); !there) return there;
  return {};
}

}  // namespace

Expected<GraphicsDevices> GraphicsDevices::open(const GraphicsSetup& setup) {
  GraphicsDevices devices;
  if (auto done = devices.open_named_cameras(setup); !done) return tl::unexpected(done.error());
  if (auto done = devices.open_tracker(setup); !done) return tl::unexpected(done.error());
  if (auto done = devices.open_other_camera(setup); !done) return tl::unexpected(done.error());
  if (setup.player || setup.mouse)
    if (auto done = open_into(devices.hand_, setup.drivers, device::HandRequest{setup.stand_in}); !done)
      return tl::unexpected(done.error());
  return devices;
}

// The right one first: of two recordings the left one must not run ahead.
Expected<void> GraphicsDevices::open_named_cameras(const GraphicsSetup& setup) {
  if (setup.right_camera) {
    const auto* driver = setup.drivers.find_for(setup.right_camera->uri);
    one_clock_ = driver == nullptr || !driver->own_clock;
    if (auto done = open_into(right_, setup.drivers, sized(*setup.right_camera, *setup.rig.right_camera));
        !done)
      return done;
  }
  if (!setup.camera) return {};
  return open_into(camera_, setup.drivers, sized(*setup.camera, *setup.rig.camera));
}

Expected<void> GraphicsDevices::open_tracker(const GraphicsSetup& setup) {
  if (setup.tracker) return open_into(tracker_, setup.drivers, *setup.tracker);
  if (setup.rig.board) {
    no_tracker_ = std::make_unique<NoTracker>();
    return {};
  }
  auto done = open_into(tracker_, setup.drivers, device::TrackerRequest{setup.stand_in, {}});
  if (!done && setup.camera && setup.drivers.names_tracker(setup.stand_in))
    return refused("{}, or name a real tracker (--tracker igtl://HOST:PORT)", done.error().message);
  return done;
}

Expected<void> GraphicsDevices::open_other_camera(const GraphicsSetup& setup) {
  if (camera_) return {};
  if (auto done = open_into(camera_, setup.drivers, device::CameraRequest{setup.stand_in, {}}); !done)
    return done;
  if (!rig::has_two_eyes(setup.rig)) return {};
  auto right = camera_->right();
  if (!right) return tl::unexpected(right.error());
  right_of_pair_ = *right;
  return {};
}

device::TrackerDevice& GraphicsDevices::tracker() const {
  return tracker_ ? tracker_->device() : *no_tracker_;
}

device::CameraDevice* GraphicsDevices::right_camera() const {
  return right_ ? &right_->device() : right_of_pair_;
}

Expected<void> GraphicsDevices::look() const {
  if (auto there = look_at(camera_); !there) return there;
  if (auto there = look_at(right_); !there) return there;
  if (auto there = look_at(tracker_); !there) return there;
  return look_at(hand_);
}

}  // namespace palpate::server::session
