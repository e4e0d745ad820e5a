#include "palpate/record/session/recorded_drivers.h"

#include <atomic>
#include <memory>
#include <utility>

#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/internal/picture_writer.h"
#include "palpate/record/session/tick_messages.h"
#include "palpate/time/clock.h"
#include "palpate_recording.pb.h"

namespace palpate::record::session {
namespace {

std::int64_t now_ns() { return MonotonicClock<PhysicsClock>::monotonic_ns(); }

void write_at(SessionRecording& recording, RecordStream& stream, std::int64_t monotonic_ns,
              std::string_view bytes) {
  const auto time = recording.log_time(monotonic_ns);
  stream.write(time, time, bytes);
}

class RecordedArmDevice : public device::ArmDevice {
 public:
  RecordedArmDevice(device::ArmDevice& arm, SessionRecording& recording)
      : arm_(arm),
        recording_(recording),
        stream_(recording.stream("/arm/sample", "palpate.recording.ArmSample")) {}
  device::ArmSample read() override {
    RecordedHapticTick recorded;
    recorded.tick.sample = arm_.read();
    recorded.tick.begun = {Duration(now_ns())};
    recorded.inputs.exact = false;  // of no loop
    if (recorded.tick.sample.stamp != last_)
      write_at(recording_, stream_, recorded.tick.begun.ns(), encode_sample(recorded));
    last_ = recorded.tick.sample.stamp;
    return recorded.tick.sample;
  }
  void command(const Vector3& force) override { arm_.command(force); }
  device::JointMotors* motors() override { return arm_.motors(); }
  void let_go() noexcept override { arm_.let_go(); }

 private:
  device::ArmDevice& arm_;
  SessionRecording& recording_;
  RecordStream& stream_;
  std::optional<Instant<ArmClock>> last_;
};

class RecordedTrackerDevice : public device::TrackerDevice {
 public:
  RecordedTrackerDevice(device::TrackerDevice& tracker, SessionRecording& recording)
      : tracker_(tracker),
        recording_(recording),
        stream_(recording.stream("/tracker/sample", "palpate.recording.TrackerSample")) {}
  std::vector<device::TrackerSample> poll() override {
    auto samples = tracker_.poll();
    const auto now = now_ns();
    for (const auto& sample : samples)
      write_at(recording_, stream_, now, encode(RecordedTrackerSample{sample, now}));
    return samples;
  }

 private:
  device::TrackerDevice& tracker_;
  SessionRecording& recording_;
  RecordStream& stream_;
};

class RecordedCameraDevice : public device::CameraDevice {
 public:
  RecordedCameraDevice(device::CameraDevice& camera, SessionRecording& recording,
                       const PictureRecording& pictures, const std::string& name)
      : camera_(camera),
        recording_(recording),
        stream_(recording.stream("/camera/" + name + "/stamp", "palpate.recording.CameraStamp")) {
    if (pictures.wanted()) pictures_ = std::make_unique<PictureWriter>(recording, pictures, name);
  }
  std::optional<device::CameraImage> poll() override { return written(camera_.poll()); }
  std::optional<device::CameraImage> poll_unseen() override {
    return written(pictures_ ? camera_.poll() : camera_.poll_unseen());
  }

 private:
  std::optional<device::CameraImage> written(std::optional<device::CameraImage> image) {
    if (!image) return image;
    const std::int64_t arrived = now_ns() - image->waited.count();
    RecordedCameraStamp stamp;
    stamp.image.mid_exposure = image->mid_exposure;
    stamp.image.frame = image->frame;
    stamp.image.width = image->width;
    stamp.image.height = image->height;
    stamp.arrived_ns = arrived;
    write_at(recording_, stream_, arrived, encode(stamp));
    if (pictures_ && !image->rgb.empty()) pictures_->write(*image, arrived);
    return image;
  }

  device::CameraDevice& camera_;
  SessionRecording& recording_;
  RecordStream& stream_;
  std::unique_ptr<PictureWriter> pictures_;
};

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
    if (!right_) right_ = std::make_unique<RecordedCameraDevice>(**right, recording_, pictures_, "right");
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
                  auto device = std::make_unique<RecordedArmDevice>(arm->device(), recording);
                  return std::make_unique<RecordedArm>(std::move(arm), std::move(device));
                });
    wrap_opener(driver.tracker,
                [&recording](std::unique_ptr<device::OpenedTracker> tracker)
                    -> std::unique_ptr<device::OpenedTracker> {
                  auto device = std::make_unique<RecordedTrackerDevice>(tracker->device(), recording);
                  return std::make_unique<RecordedTracker>(std::move(tracker), std::move(device));
                });
    wrap_opener(
        driver.camera,
        [&recording, pictures,
         cameras](std::unique_ptr<device::OpenedCamera> camera) -> std::unique_ptr<device::OpenedCamera> {
          const bool first = cameras->fetch_add(1) == 0;
          auto device = std::make_unique<RecordedCameraDevice>(camera->device(), recording, pictures,
                                                               first ? "left" : "right");
          return std::make_unique<RecordedCamera>(std::move(camera), std::move(device), recording, pictures);
        });
    recorded.add(std::move(driver));
  }
  return recorded;
}

}  // namespace palpate::record::session
