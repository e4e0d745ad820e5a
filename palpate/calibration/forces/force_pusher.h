// Pushes the tip of an arm that nobody has checked yet: little, slowly, and not a tick longer than all is well.
//
// The way from a wished force to the arm is the haptic loop's: the calibrated kinematics turn it into the device's own
// axes, or into the torques of its motors, and the last clamp lets nothing out above the peak. While a force is on or still held, every tick looks whether the
// key is held, how far and how fast the tip has gone, whether the reading is fresh and good, and whether the tick itself
// came in time. Where anything is not as it should be the arm is commanded nothing and told to let go in that very tick;
// then there is no force until the next push.
//
// ArmBase axes, N, m, s. One thread, at 1 kHz; tick() does not allocate.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "palpate/device/devices.h"
#include "palpate/haptics/arm_force.h"
#include "palpate/haptics/last_clamp.h"
#include "palpate/haptics/tip_filter.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration::forces {

enum class BreakOff : std::uint8_t {
  none,
  key_released,
  too_far,
  too_fast,
  arm_silent,
  arm_lost,
  bad_reading,
  outside_workspace,
  late_tick
};
inline constexpr int kBreakOffs = 9;
std::string_view name_of(BreakOff reason);

struct PushLimits {
  double peak_n = 0.5;
  double slew_n_s = 50.0;
  double most_way_m = 0.010;  // from where the push began
  double most_speed_m_s = 0.1;
  double stale_s = 0.005;  // no fresh reading, or no tick, for so long
};

class ForcePusher {
 public:
  // Arm must outlive it. Throws std::invalid_argument where the rig has no arm calibration, or one of another number of
  // joints than the arm's motors have.
  ForcePusher(device::ArmDevice& arm, const rig::Rig& rig, const PushLimits& limits = {});
  ~ForcePusher();  // no force

  // Reads the arm and commands `force`. Not none: nothing was commanded, and the arm was told to let go.
  BreakOff tick(Instant<PhysicsClock> now, const Vector3& force, bool key_held);
  // From here on the way is measured.
  void begin() { start_ = tip_; }

  const Vector3& tip() const { return tip_; }
  Vector3 way() const { return tip_ - start_; }
  double speed() const { return filter_.velocity().norm(); }
  const Vector3& velocity() const { return velocity_; }
  const device::TipJacobian& jacobian() const { return J_; }
  std::uint32_t buttons() const { return buttons_; }
  double gain() const { return device_.gain; }  // of the device's own axes: |commanded| / |force| at most

 private:
  BreakOff look(Instant<PhysicsClock> now, const device::ArmSample& sample);
  void command(const Vector3& force);

  device::ArmDevice& arm_;
  rig::ArmCalibration calibration_;
  std::unique_ptr<const device::ArmKinematics> kinematics_, nominal_;  // calibrated; the maker's
  device::JointMotors* motors_;  // of an arm that takes torques; else null
  device::JointVector torque_limits_;
  PushLimits limits_;
  haptics::LastClamp clamp_;
  haptics::TipFilter filter_;
  haptics::DeviceForce device_;
  device::TipJacobian J_;
  Vector3 tip_ = Vector3::Zero(), start_ = Vector3::Zero(), velocity_ = Vector3::Zero();
  std::uint32_t buttons_ = 0;
  bool begun_ = false, sampled_ = false;
  Instant<PhysicsClock> last_tick_, last_fresh_;
  Instant<ArmClock> last_stamp_;
};

}  // namespace palpate::calibration::forces
