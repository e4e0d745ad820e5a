#include "tools/commands/device_recording.h"

#include "palpate/calibration/session/sample_csv.h"
#include "palpate/record/session/recorded_drivers.h"
#include "palpate/record/session/recorded_tables.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"

namespace palpate::tools::commands {

using calibration::session::AcquisitionContext;

Expected<DeviceRecording> DeviceRecording::begin(const RecordOptions& options, const std::string& recorder,
                                                 const rig::Rig& rig, bool computed) {
  auto pictures = picture_recording(options);
  if (!pictures) return tl::unexpected(pictures.error());
  DeviceRecording devices;
  devices.drivers_ = commands::drivers();
  if (options.file.empty()) return devices;
  auto begun = record::session::SessionRecording::begin(
      options.file, {.recorder = recorder, .on_error = {}, .wall_time = !computed});
  if (!begun) return tl::unexpected(begun.error());
  if (auto done = (*begun)->attach("rig-before.toml", "application/toml", rig::rig_text(rig)); !done)
    return tl::unexpected(done.error());
  devices.recording_ = std::move(*begun);
  devices.pictures_ = std::move(*pictures);
  devices.drivers_ =
      record::session::recorded_drivers(devices.drivers_, *devices.recording_, devices.pictures_);
  return devices;
}

AcquisitionContext DeviceRecording::recorded(const AcquisitionContext& devices) {
  if (!recording_) return devices;
  const auto now = [&clock = devices.clock] { return clock.now().ns(); };
  const auto seen = [&](device::CameraDevice* camera, const char* name) {
    return camera == nullptr ? nullptr
                             : record::session::recorded_device(*camera, *recording_, pictures_, name, now);
  };
  arm_ = record::session::recorded_device(devices.arm, *recording_, now);
  tracker_ = record::session::recorded_device(devices.tracker, *recording_, now);
  camera_ = seen(devices.camera, "left");
  right_camera_ = seen(devices.right_camera, "right");
  return {devices.clock,        *arm_,       *tracker_, camera_.get(), devices.person, right_camera_.get(),
          devices.computed_arm, devices.stop};
}

void DeviceRecording::keep_tables(const calibration::session::CalibrationRecordings& recordings,
                                  const rig::Rig& rig) {
  if (!recording_) return;
  const Vector3 tip = rig.tip_pivot ? rig.tip_pivot->tip_in_marker : Vector3(Vector3::Zero());
  for (const auto& [name, text] : calibration::session::session_tables(recordings, tip)) {
    std::string& last = tables_[name];
    if (last == text) continue;
    last = text;
    if (auto done = recording_->attach(record::session::table_attachment(name), "text/csv", text); !done)
      notice(done.error().message);
  }
}

Expected<void> DeviceRecording::finish(const rig::Rig& rig) {
  if (!recording_) return {};
  if (auto kept = recording_->attach("rig.toml", "application/toml", rig::rig_text(rig)); !kept)
    notice(kept.error().message);
  if (auto whole = recording_->finish(); !whole) return tl::unexpected(whole.error());
  return {};
}

}  // namespace palpate::tools::commands
