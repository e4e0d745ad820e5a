// The recording of a session with devices that no server holds, where --record asks for one: calibrate all, verify.
//
// One thread: that of the session.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "palpate/calibration/session/acquisition_context.h"
#include "palpate/calibration/session/calibration_session.h"
#include "palpate/device/driver_registry.h"
#include "palpate/record/session/session_recording.h"
#include "palpate/rig/rig.h"
#include "tools/commands/record_options.h"

namespace palpate::tools::commands {

class DeviceRecording {
 public:
  // `recorder`: the command that records; `rig`: as it is before, an attachment; `computed`: of a simulated laboratory,
  // whose time it keeps. Wrong use: options that do not fit; refused: a file that cannot be written.
  static Expected<DeviceRecording> begin(const RecordOptions& options, const std::string& recorder,
                                         const rig::Rig& rig, bool computed = false);

  // This program's drivers; where something is recorded, what they open goes into it.
  const device::DriverRegistry& drivers() const { return drivers_; }
  // The same for devices that are open already, which must outlive it. Once.
  calibration::session::AcquisitionContext recorded(const calibration::session::AcquisitionContext& devices);

  // What a calibration worked on, as attachments: the newest of each name counts.
  void keep_tables(const calibration::session::CalibrationRecordings& recordings, const rig::Rig& rig);

  // With the rig as it is afterwards. Refused where the file is not whole, with what is missing.
  Expected<void> finish(const rig::Rig& rig);

 private:
  DeviceRecording() = default;

  std::unique_ptr<record::session::SessionRecording> recording_;
  record::session::PictureRecording pictures_;
  std::map<std::string, std::string> tables_;  // as they were attached last
  device::DriverRegistry drivers_;
  std::unique_ptr<device::ArmDevice> arm_;
  std::unique_ptr<device::TrackerDevice> tracker_;
  std::unique_ptr<device::CameraDevice> camera_, right_camera_;
};

}  // namespace palpate::tools::commands
