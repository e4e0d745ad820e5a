// A real camera, or a recording of one, as the graphics server's camera.
//
// A thread of its own (palpate-camera) waits for frames, turns them to RGB and leaves the newest in a slot;
// poll() takes it from there and never waits for the camera. A picture is stamped with its mid-exposure in
// the camera's clock, whatever that counts from; a ClockEstimator leads to the host's time. A camera that is
// gone is opened again until it is back. One thread uses the object; make it from an ordinary one, because
// its thread inherits the scheduling class.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/cameras/frame_source.h"
#include "palpate/device/devices.h"
#include "palpate/device/health.h"
#include "palpate/device/heartbeat_monitor.h"
#include "palpate/device/spare_pixels.h"

namespace palpate::drivers::cameras {

struct CameraStatus {
  std::optional<device::HealthReport> health;  // none: it runs
  std::uint64_t pictures = 0;                  // handed to the slot
  std::uint64_t damaged = 0;                   // came and could not be used
  std::uint64_t dropped = 0;                   // missing in the camera's own count
  std::uint64_t times_opened = 0;              // 1, and once more after each loss
};

class LiveCamera : public device::CameraDevice {
 public:
  // How long a camera may be silent before that is said: below half a second with all that follows, where
  // pictures come at least every 0.16 s.
  static constexpr Duration kSilence = std::chrono::milliseconds(300);
  // ... at first, since webcams take their time to begin; and when to give up and open it anew.
  static constexpr Duration kFirstPicture = std::chrono::milliseconds(1500);
  static constexpr Duration kOpenAnew = std::chrono::milliseconds(1000);

  // The source is opened at once, and refused as it says itself. `width`, `height` in px: what pictures must
  // have, 0 where any will do.
  static Expected<std::unique_ptr<LiveCamera>> open(std::unique_ptr<FrameSource> source, int width = 0,
                                                    int height = 0);
  ~LiveCamera() override;

  std::optional<device::CameraImage> poll() override;
  void take_back(device::CameraImage image) override;
  CameraStatus status() const;
  const std::string& name() const { return name_; }
  CameraFacts facts() const;  // those of the last opening

 private:
  LiveCamera(std::unique_ptr<FrameSource> source, CameraFacts facts, int width, int height);
  void run();
  void take(const Frame& frame);
  bool pause(Duration time);  // false when the camera is to end
  void set_lost(std::string words);
  void set_trouble(std::string words);  // mutex_ held
  // Whether it is silent, as its own thread sees it: a caller that stands still while it draws neither delays
  // that nor is misled by it.
  void judge();

  const std::unique_ptr<FrameSource> source_;  // of the thread alone
  const std::string name_;
  const int width_, height_;
  std::uint64_t last_number_ = 0;  // of the thread alone, as what follows
  device::CameraImage next_;
  device::HeartbeatMonitor silence_;

  mutable std::mutex mutex_;  // held for moments; guards what follows
  std::condition_variable wake_;
  bool stop_ = false;
  std::optional<device::CameraImage> newest_;
  device::SparePixels spare_;
  CameraStatus status_;  // counts
  CameraFacts facts_;
  std::string lost_, trouble_;    // why it is gone; what is wrong with the pictures that come
  std::int64_t troubled_ns_ = 0;  // when the latest of these came
  bool ended_ = false, silent_ = false;
  std::int64_t heard_ns_ = 0;    // the latest good picture, or when one is due at the earliest
  std::int64_t stamped_ns_ = 0;  // the moment of this host with which its stamp is to be compared
  std::thread thread_;           // last: it uses all of the above
};

}  // namespace palpate::drivers::cameras
