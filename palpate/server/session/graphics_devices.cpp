#include "palpate/server/session/graphics_devices.h"

#include <utility>

namespace palpate::server::session {
namespace {

namespace cameras = drivers::cameras;
namespace laboratory = drivers::laboratory;

// The server of a rig with a board asks nobody: the picture says where the camera is.
class NoTracker : public device::TrackerDevice {
 public:
  std::vector<device::TrackerSample> poll() override { return {}; }
};

// Set to the size that was calibrated.
Expected<std::unique_ptr<cameras::LiveCamera>> open_for(cameras::CameraRequest request,
                                                        const rig::CameraCalibration& calibrated) {
  request.settings.width = calibrated.model.width;
  request.settings.height = calibrated.model.height;
  return cameras::open_camera(request);
}

// Puts what was opened into its place.
template <typename Device, typename Opened>
Expected<void> keep(std::unique_ptr<Device>& place, Expected<std::unique_ptr<Opened>> opened) {
  if (!opened) return tl::unexpected(opened.error());
  place = std::move(*opened);
  return {};
}

}  // namespace

Expected<GraphicsDevices> GraphicsDevices::open(const GraphicsProcessOptions& options) {
  GraphicsDevices devices;
  if (auto done = devices.open_live_cameras(options); !done) return tl::unexpected(done.error());
  if (auto done = devices.open_laboratory(options); !done) return tl::unexpected(done.error());
  if (auto done = devices.open_tracker(options); !done) return tl::unexpected(done.error());
  if (auto done = devices.open_laboratory_cameras(options); !done) return tl::unexpected(done.error());
  if (options.player || options.mouse)
    if (auto done = keep(devices.hand_, laboratory::LabHand::open(devices.laboratory_)); !done)
      return tl::unexpected(done.error());
  return devices;
}

// The right one first: of two recordings the left one must not run ahead.
Expected<void> GraphicsDevices::open_live_cameras(const GraphicsProcessOptions& options) {
  if (options.right_camera) {
    live_right_by_own_clock_ = options.right_camera->choice.kind == cameras::Kind::aravis;
    if (auto done = keep(live_right_, open_for(*options.right_camera, *options.rig.right_camera)); !done)
      return done;
  }
  if (!options.camera) return {};
  return keep(live_camera_, open_for(*options.camera, *options.rig.camera));
}

Expected<void> GraphicsDevices::open_laboratory(const GraphicsProcessOptions& options) {
  const bool on_board = options.rig.board.has_value();
  const bool tracks = !options.tracker && !on_board;
  if (!tracks && options.camera && !options.player && !options.mouse) return {};
  auto client = laboratory::LabClient::open(options.lab);
  if (!client && options.camera && tracks)
    return refused("{}, or name a real tracker (--tracker igtl://HOST:PORT)", client.error().message);
  if (!client) return tl::unexpected(client.error());
  laboratory_ = std::move(*client);
  return {};
}

Expected<void> GraphicsDevices::open_tracker(const GraphicsProcessOptions& options) {
  if (options.tracker) return keep(live_tracker_, server::graphics::open_live_tracker(*options.tracker));
  if (options.rig.board)
    other_tracker_ = std::make_unique<NoTracker>();
  else
    other_tracker_ = std::make_unique<laboratory::LabTracker>(laboratory_);
  return {};
}

Expected<void> GraphicsDevices::open_laboratory_cameras(const GraphicsProcessOptions& options) {
  if (live_camera_) return {};
  if (auto done = keep(lab_camera_, laboratory::LabCamera::open(laboratory_)); !done) return done;
  if (laboratory_->cameras() < 2 || !rig::has_two_eyes(options.rig)) return {};
  return keep(lab_right_, laboratory::LabCamera::open(laboratory_, 1));
}

device::TrackerDevice& GraphicsDevices::tracker() const {
  return live_tracker_ ? static_cast<device::TrackerDevice&>(*live_tracker_) : *other_tracker_;
}

device::CameraDevice& GraphicsDevices::camera() const {
  return live_camera_ ? static_cast<device::CameraDevice&>(*live_camera_) : *lab_camera_;
}

device::CameraDevice* GraphicsDevices::right_camera() const {
  if (lab_right_) return lab_right_.get();
  return live_right_.get();
}

bool GraphicsDevices::one_clock() const { return lab_right_ || !live_right_by_own_clock_; }

}  // namespace palpate::server::session
