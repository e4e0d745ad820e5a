#include "palpate/record/session/recorded_devices.h"

#include <optional>
#include <utility>

#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/internal/picture_writer.h"
#include "palpate/record/session/tick_messages.h"
#include "palpate_recording.pb.h"

namespace palpate::record::session {
namespace {

void write_at(SessionRecording& recording, RecordStream& stream, std::int64_t monotonic_ns,
              std::string_view bytes) {
  const auto time = recording.log_time(monotonic_ns);
  stream.write(time, time, bytes);
}

class RecordedArmDevice : public device::ArmDevice {
 public:
  RecordedArmDevice(device::ArmDevice& arm, SessionRecording& recording, HostTime host_time)
      : arm_(arm),
        recording_(recording),
        host_time_(std::move(host_time)),
        stream_(recording.stream("/arm/sample", "palpate.recording.ArmSample")) {}
  device::ArmSample read() override {
    RecordedHapticTick recorded;
    recorded.tick.sample = arm_.read();
    recorded.tick.begun = {Duration(host_time_())};
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
  HostTime host_time_;
  RecordStream& stream_;
  std::optional<Instant<ArmClock>> last_;
};

class RecordedTrackerDevice : public device::TrackerDevice {
 public:
  RecordedTrackerDevice(device::TrackerDevice& tracker, SessionRecording& recording, HostTime host_time)
      : tracker_(tracker),
        recording_(recording),
        host_time_(std::move(host_time)),
        stream_(recording.stream("/tracker/sample", "palpate.recording.TrackerSample")) {}
  std::vector<device::TrackerSample> poll() override {
    auto samples = tracker_.poll();
    const auto now = host_time_();
    for (const auto& sample : samples) {
      const std::int64_t arrived = now - sample.waited.count();
      write_at(recording_, stream_, arrived, encode(RecordedTrackerSample{sample, arrived}));
    }
    return samples;
  }

 private:
  device::TrackerDevice& tracker_;
  SessionRecording& recording_;
  HostTime host_time_;
  RecordStream& stream_;
};

class RecordedCameraDevice : public device::CameraDevice {
 public:
  RecordedCameraDevice(device::CameraDevice& camera, SessionRecording& recording,
                       const PictureRecording& pictures, const std::string& name, HostTime host_time)
      : camera_(camera),
        recording_(recording),
        host_time_(std::move(host_time)),
        stream_(recording.stream("/camera/" + name + "/stamp", "palpate.recording.CameraStamp")) {
    if (pictures.wanted()) pictures_ = std::make_unique<PictureWriter>(recording, pictures, name);
  }
  std::optional<device::CameraImage> poll() override { return written(camera_.poll()); }
  std::optional<device::CameraImage> poll_unseen() override {
    return written(pictures_ ? camera_.poll() : camera_.poll_unseen());
  }
  void take_back(device::CameraImage image) override { camera_.take_back(std::move(image)); }

 private:
  std::optional<device::CameraImage> written(std::optional<device::CameraImage> image) {
    if (!image) return image;
    const std::int64_t arrived = host_time_() - image->waited.count();
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
  HostTime host_time_;
  RecordStream& stream_;
  std::unique_ptr<PictureWriter> pictures_;
};

}  // namespace

std::unique_ptr<device::ArmDevice> recorded_device(device::ArmDevice& arm, SessionRecording& recording,
                                                   HostTime host_time) {
  return std::make_unique<RecordedArmDevice>(arm, recording, std::move(host_time));
}

std::unique_ptr<device::TrackerDevice> recorded_device(device::TrackerDevice& tracker,
                                                       SessionRecording& recording, HostTime host_time) {
  return std::make_unique<RecordedTrackerDevice>(tracker, recording, std::move(host_time));
}

std::unique_ptr<device::CameraDevice> recorded_device(device::CameraDevice& camera,
                                                      SessionRecording& recording,
                                                      const PictureRecording& pictures,
                                                      const std::string& name, HostTime host_time) {
  return std::make_unique<RecordedCameraDevice>(camera, recording, pictures, name, std::move(host_time));
}

}  // namespace palpate::record::session
