#include "palpate/record/session/recorded_drivers.h"

#include <atomic>
#include <memory>
#include <utility>

#include "palpate/time/clock.h"

namespace palpate::record::session {
namespace {

std::int64_t monotonic_ns() { return MonotonicClock<PhysicsClock>::monotonic_ns(); }

// What a driver has opened, with a device of ours before it.
template <typename OpenedDevice, typename Device>
class RecordedOpened : public OpenedDevice {
 public:
  RecordedOpened(std::unique_ptr<OpenedDevice> opened, std::unique_ptr<Device> device)
      : opened_(std::move(opened)), device_(std::move(device)) {}
  Device& device() override { return *device_; }
  Expected<void> look() override { return opened_->look(); }
  std::optional<device::HealthReport> health() override { return opened_->health(); }
  Json figures() const override { return opened_->figures(); }

 protected:
  std::unique_ptr<OpenedDevice> opened_;  // gone last
  std::unique_ptr<Device> device_;
};

class RecordedArm : public RecordedOpened<device::OpenedArm, device::ArmDevice> {
 public:
  using RecordedOpened::RecordedOpened;
  device::ArmFacts facts() const override { return opened_->facts(); }
  std::string description() const override { return opened_->description(); }
};

class RecordedTracker : public RecordedOpened<device::OpenedTracker, device::TrackerDevice> {
 public:
  using RecordedOpened::RecordedOpened;
  std::string why_unheard() const override { return opened_->why_unheard(); }
};

class RecordedCamera : public RecordedOpened<device::OpenedCamera, device::CameraDevice> {
 public:
  RecordedCamera(std::unique_ptr<device::OpenedCamera> opened, std::unique_ptr<device::CameraDevice> device,
                 SessionRecording& recording, PictureRecording pictures)
      : RecordedOpened(std::move(opened), std::move(device)),
        recording_(recording),
        pictures_(std::move(pictures)) {}
  bool simulated() const override { return opened_->simulated(); }
  std::string name() const override { return opened_->name(); }
  std::string description() const override { return opened_->description(); }
  double exposure_s() const override { return opened_->exposure_s(); }
  bool ended() const override { return opened_->ended(); }
  Expected<device::CameraDevice*> right() override {
    auto right = opened_->right();
    if (!right || *right == nullptr) return right;
    if (!right_) right_ = recorded_device(**right, recording_, pictures_, "right", monotonic_ns);
    return right_.get();
  }

 private:
  SessionRecording& recording_;
  PictureRecording pictures_;
  std::unique_ptr<device::CameraDevice> right_;
};

// The same opener; what it opens goes through `wrap`.
template <typename Opener, typename Wrap>
void wrap_opener(std::optional<Opener>& opener, Wrap wrap) {
  if (!opener) return;
  opener->open =
      [open = opener->open,
       wrap](const typename Opener::Request& request) -> Expected<std::unique_ptr<typename Opener::Opened>> {
    auto opened = open(request);
    if (!opened || *opened == nullptr) return opened;
    return wrap(std::move(*opened));
  };
}

}  // namespace

device::DriverRegistry recorded_drivers(const device::DriverRegistry& drivers, SessionRecording& recording,
                                        const PictureRecording& pictures) {
  const auto cameras = std::make_shared<std::atomic<int>>(0);
  device::DriverRegistry recorded;
  for (device::Driver driver : drivers.drivers()) {
    wrap_opener(driver.arm,
                [&recording](std::unique_ptr<device::OpenedArm> arm) -> std::unique_ptr<device::OpenedArm> {
                  auto device = recorded_device(arm->device(), recording, monotonic_ns);
                  return std::make_unique<RecordedArm>(std::move(arm), std::move(device));
                });
    wrap_opener(driver.tracker,
                [&recording](std::unique_ptr<device::OpenedTracker> tracker)
                    -> std::unique_ptr<device::OpenedTracker> {
                  auto device = recorded_device(tracker->device(), recording, monotonic_ns);
                  return std::make_unique<RecordedTracker>(std::move(tracker), std::move(device));
                });
    wrap_opener(
        driver.camera,
        [&recording, pictures,
         cameras](std::unique_ptr<device::OpenedCamera> camera) -> std::unique_ptr<device::OpenedCamera> {
          const bool first = cameras->fetch_add(1) == 0;
          auto device =
              recorded_device(camera->device(), recording, pictures, first ? "left" : "right", monotonic_ns);
          return std::make_unique<RecordedCamera>(std::move(camera), std::move(device), recording, pictures);
        });
    recorded.add(std::move(driver));
  }
  return recorded;
}

}  // namespace palpate::record::session
