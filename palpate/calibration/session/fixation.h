// "Hold the tip here": a spring and damper rendered through the arm at 1 kHz, from encoder readings alone.
//
// ArmBase axes of the device's nominal kinematics, N, m. A pulling hand drags the tip by pull / stiffness;
// that is real and wanted in the record, not hidden. Its ticks do not allocate; one thread.
#pragma once

#include <memory>

#include "palpate/device/arm_kinematics.h"
#include "palpate/device/devices.h"

namespace palpate::calibration::session {

struct FixationSettings {
  device::ArmModel nominal;       // with as many joints as the readings have
  double stiffness = 800.0;       // N/m; up to the device's largest stable stiffness
  double damping = 12.0;          // N s/m, on the filtered speed
  double speed_filter_s = 0.004;  // encoder steps of 0.03 mm would be felt as a buzz without
};

class Fixation {
 public:
  Fixation(const FixationSettings& settings, const device::ArmSample& here);
  // Force for this reading; readings come in time order.
  Vector3 force(const device::ArmSample& sample);
  double displacement() const { return displacement_; }  // m, by nominal kinematics

 private:
  Vector3 tip(const device::ArmSample& sample) const;

  FixationSettings settings_;
  std::unique_ptr<const device::ArmKinematics> arm_;
  Vector3 held_, last_, speed_ = Vector3::Zero();
  Instant<ArmClock> last_stamp_;
  double displacement_ = 0.0;
};

}  // namespace palpate::calibration::session
