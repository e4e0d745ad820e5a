// "Hold the tip here": a spring and damper rendered through the arm at 1 kHz, from encoder readings alone.
//
// ArmBase axes of the device's nominal kinematics, N, m. A pulling hand drags the tip by pull / stiffness;
// that is real and wanted in the record, not hidden. Does not allocate; one thread.
#pragma once

#include "palpate/device/devices.h"
#include "palpate/device/phantom.h"

namespace palpate::calibration::session {

struct FixationSettings {
  device::PhantomLengths nominal;
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
  FixationSettings settings_;
  Vector3 held_, last_, speed_ = Vector3::Zero();
  Instant<ArmClock> last_stamp_;
  double displacement_ = 0.0;
};

}  // namespace palpate::calibration::session
