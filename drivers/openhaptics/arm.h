// The haptic arms of SensAble and 3D Systems (PHANToM, Touch) through the maker's OpenHaptics library.
//
// Two loops meet here. The library runs a cycle of its own every millisecond in a thread of its own: it reads
// the encoders, which may take as long as the cable takes, and hands over the force. The haptic loop never
// waits for it: read() takes the newest sample and command() leaves the newest force, through mailboxes
// without locks. The price is that a force reaches the motors up to one cycle later.
//
// Frames: the library's axes are those of ArmBase (x to the user's right, y up, z towards the user); its
// millimetres end here. Joints are the angles psi of palpate/device/phantom.h; gimbal angles are taken from
// the stylus' orientation that the library tells, because which way they count differs between models. Arms
// also differ in which turn of the turret is positive: the side the tip is on decides.
//
// What can go wrong is a state, told by status(): nobody needs to poll it for safety. While there is no fresh
// sample read() gives joints that are not numbers, at which the haptic loop fades its forces; while there is
// no fresh command the driver fades them itself. A device that is gone is said to be gone
// (ArmSample::connected): forces stay off until somebody re-arms. It is given back, and opened again when it
// returns. What a fade has held back is not made up for later; what was commanded and not given, for
// whichever of these reasons, is told with each sample (ArmSample::withheld).
//
// Threads: read() and command() by the haptic loop, status() by one ordinary thread; a thread of this object
// ("palpate-hd") opens, closes and watches. Refused at opening: library or device that cannot be had, with
// the reason and what to do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/arms/loop_mailbox.h"
#include "palpate/device/devices.h"
#include "palpate/device/health.h"
#include "palpate/device/phantom.h"

namespace palpate::drivers::openhaptics {

struct ArmSettings {
  std::string name;                // as the maker's setup program has it; empty: the default device
  std::filesystem::path library;   // empty: library.h says where it is looked for
  device::PhantomLengths lengths;  // the maker's, to check angles against places
  arms::LoopSettings loop{};
  double hold_s = 0.5;  // forces stay off this long after the device has last complained of one
  // A person says that the arm is in its reset position now: encoders that have lost their zero are set.
  bool at_reset_position = false;
};

struct ArmFacts {
  std::string name, model, serial, driver, library, library_version;
  double peak_n = 0.0, continuous_n = 0.0;  // as the device states them
};

struct ArmStatus {
  // arm_lost, arm_inconsistent, arm_uncalibrated or arm_forces_off, with the reason and what to do; none: it runs.
  std::optional<device::HealthReport> health;
  std::uint64_t cycles = 0;  // of the library, since the start
  std::uint64_t force_errors = 0, stale_cycles = 0, refused_commands = 0, times_lost = 0;
};

class OpenHapticsArm : public device::ArmDevice {
 public:
  // Returns when the first cycle has ended, with or without a sample: status() tells. From an ordinary
  // thread.
  static Expected<std::unique_ptr<OpenHapticsArm>> open(const ArmSettings& settings);
  ~OpenHapticsArm() override;  // forces off, device given back

  // Stamped in the machine's monotonic clock. Not numbers while there is no sample of the last watchdog_s.
  device::ArmSample read() override;
  // Cut to the device's own peak; what is no number counts as none.
  void command(const Vector3& force) override;
  // Off with the library's next cycle, a millisecond later.
  void let_go() noexcept override;

  ArmStatus status() const;
  const ArmFacts& facts() const;

 private:
  class Connection;
  explicit OpenHapticsArm(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

// The device that "openhaptics" (the default one: "") or "openhaptics:NAME" asks for; nothing for other
// texts.
std::optional<std::string> device_asked_for(std::string_view text);

// Opens the device, asks who it is and gives it back, without a force or a cycle.
Expected<ArmFacts> probe_arm(const ArmSettings& settings);

}  // namespace palpate::drivers::openhaptics
