// What a device is to the rest of the system. Simulated devices and real drivers implement the same small
// interfaces.
//
// One stamped sample per cycle, stamped in the device's own clock. No default behaviour: a device that is
// absent is an error at opening, never an object that returns zeros. Each object is used by one thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/joints.h"
#include "palpate/math/pose.h"
#include "palpate/time/instant.h"

namespace palpate::device {

// --- haptic arm

struct ArmSample {
  Instant<ArmClock> stamp;
  // psi, encoder readings as angles, rad, uncorrected; always as many as the arm has joints.
  JointVector joints = JointVector::filled(3, 0.0);
  Vector3 gimbal = Vector3::Zero();  // rad, uncorrected; zeros where the arm has none
  // False: the device says that it is gone (unplugged, faulted, closed); the rest is what it said last.
  // Forces then stay off until somebody re-arms, as its encoders may have lost their zero.
  bool connected = true;
  // N s, device's axes as of command(), since it was opened: what was commanded and is known not to have been
  // given (the device's limits, its refusals, ramps of its driver). 0 where a device cannot tell.
  Vector3 withheld = Vector3::Zero();
  // Since these readings were made, as far as the device knows; not negative.
  Duration waited{0};
  // N, device's axes as of command(): what its motors give now. A device lets go of a command that is too
  // old, 20 ms at most. Nothing where it cannot tell.
  std::optional<Vector3> held;
  // Of the stylus that are pressed now: the first is bit 0. None on an arm without buttons.
  std::uint32_t buttons = 0;
};

// A device lets go of a force when no new command has come for this long, at the latest.
inline constexpr Duration kLongestHold = std::chrono::milliseconds(20);

// The motors of an arm that is commanded by torques.
class JointMotors {
 public:
  virtual ~JointMotors() = default;
  // N m at the joints, one for each reading of ArmSample::joints and of its sign; held until the next
  // command, or until it is too old (kLongestHold). As ArmDevice::command otherwise. The device clamps to its
  // own limits.
  virtual void command(const JointVector& torques) = 0;
  // N m, above 0, that each may be asked for; stays as it is while the arm is open.
  virtual JointVector limits() const = 0;
};

class ArmDevice {
 public:
  virtual ~ArmDevice() = default;
  // The newest encoder reading. Called at 1 kHz by the haptic loop: does not allocate, lock or throw. A stamp
  // that does not move on for 5 ms means that the device has fallen silent; forces fade until it does.
  virtual ArmSample read() = 0;
  // Force at the tip in ArmBase axes as the device's own nominal kinematics sees them, N; held until the next
  // command, or until it is too old (kLongestHold). The device clamps to its own limits.
  virtual void command(const Vector3& force) = 0;
  // Not null: the arm takes torques. It is commanded through these alone, and what its samples say of forces
  // (withheld, held) is not used, as it knows none. The same while the arm is open.
  virtual JointMotors* motors() { return nullptr; }
  // Gives no force from now on until the next command(). From any thread, also while read() or command() hangs
  // in another, and from a signal handler: neither waits, locks nor allocates.
  virtual void let_go() noexcept = 0;
};

// --- optical tracker

enum class MarkerId : std::uint8_t { tip_marker, camera_marker, pointer };

struct TrackerSample {
  Instant<TrackerClock> stamp;  // when the LEDs were seen
  MarkerId marker = MarkerId::tip_marker;
  bool seen = false;                             // enough LEDs for a pose; the rest is meaningless otherwise
  Quaternion rotation = Quaternion::Identity();  // marker in World
  Vector3 translation = Vector3::Zero();
  // Of rotation (rad, World axes, left perturbation) then translation (m), as the tracker believes it: white
  // noise of the LEDs carried through the fit.
  Matrix6 covariance = Matrix6::Zero();
  // m^2, of the translation: what the tracker's stated accuracy leaves beyond that noise, the same for poses
  // near each other. It does not average out.
  Matrix3 systematic = Matrix3::Zero();
  int leds = 0;
  // Since it reached this host until it was asked for, as far as its driver knows; not negative.
  Duration waited{0};

  // m^2, of a point fixed to the marker: noise and systematic part.
  Matrix3 point_covariance(const Vector3& in_marker) const {
    Eigen::Matrix<double, 3, 6> J;
    J << -hat(rotation * in_marker), Matrix3::Identity();
    return J * covariance * J.transpose() + systematic;
  }
};

class TrackerDevice {
 public:
  virtual ~TrackerDevice() = default;
  // All samples that arrived since the last call, oldest first.
  virtual std::vector<TrackerSample> poll() = 0;
};

// --- camera

struct CameraImage {
  Instant<CameraClock> mid_exposure;
  std::uint64_t frame = 0;  // counts frames taken: a gap is a dropped frame
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // width * height * 3, row 0 on top
  // Until it was asked for, since the moment of this host with which its stamp is to be compared: that at which
  // it was taken where its driver can tell, else that at which it came, as far as the driver knows.
  Duration waited{0};
};

class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  // The newest image that has arrived since the last call (older ones are dropped), or none.
  virtual std::optional<CameraImage> poll() = 0;
  // The same for a caller who will not look at it: rgb stays empty, and a simulated camera need not draw.
  virtual std::optional<CameraImage> poll_unseen() {
    auto image = poll();
    if (image) image->rgb.clear();
    return image;
  }
  // An image of this camera that nobody needs any more. The next one may come in its memory: whoever takes blocks of a
  // picture's size for each, and gives them back, leaves holes between what lives longer, and grows.
  virtual void take_back(CameraImage /*image*/) {}
};

// --- display

class DisplayDevice {
 public:
  virtual ~DisplayDevice() = default;
  // From now on it shows the timecode (palpate/device/timecode.h) as it stands at time `code`, until the
  // next call. Called about each millisecond: does not wait for the display. Returns when it was handed over,
  // CLOCK_MONOTONIC, ns.
  virtual std::int64_t show_timecode(Duration code) = 0;
};

// --- the hand of a simulated person, or of a scripted player

// Where a player wants the stylus: the only way in which a script moves the simulated hand. World frame, as
// the player believes it. The hand follows as a hand does: late, soft, with bounded acceleration.
struct HandTarget {
  Point<World> tip;
  Vector3 velocity = Vector3::Zero();  // m/s
  Quaternion R_world_tip = Quaternion::Identity();
  bool head_still = false;  // the simulated person keeps the head still meanwhile
};

class HandDevice {
 public:
  virtual ~HandDevice() = default;
  virtual void move_to(const HandTarget& target) = 0;
};

}  // namespace palpate::device
