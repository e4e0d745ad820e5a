// The check of an arm's forces with a person: ramps along each axis, both ways, in several poses, while a hand holds the
// stylus lightly and another holds a key; then, if wanted, a known weight that the arm lifts.
//
// Runs in the caller's thread at 1 kHz of `clock` and returns when it is done. Every push goes through ForcePusher, whose
// limits break it off; after a break-off there is no force for more than a second, and the ramp is played again, half as
// strong where the tip had gone too far or too fast. Refused: a person who does not come, an arm that is lost, break-offs
// that do not end, a stop.
#pragma once

#include <array>
#include <atomic>
#include <string>
#include <vector>

#include "palpate/calibration/force_check.h"
#include "palpate/calibration/forces/force_pusher.h"
#include "palpate/time/clock.h"

namespace palpate::calibration::forces {

// Who holds the stylus: a person with a key, or a simulated one. Called in the session's thread, key_held() in each tick.
class ForcePerson {
 public:
  virtual ~ForcePerson() = default;
  virtual bool key_held(std::uint32_t stylus_buttons) = 0;
  virtual void say(const std::string& line) = 0;
  // The stylus is wanted in pose 0, 1, ...: a simulated hand goes there.
  virtual void pose_wanted(int pose, const Vector3& tip) = 0;
};

struct ForceSessionSettings {
  std::string key = "the space bar";  // what a person holds, in words
  int poses = 5;                      // 1 to 5
  double ramp_s = 1.2;                // up and down again
  double apart_m = 0.06;              // poses, from each other
  double patience_s = 120.0;          // for a person to get there and hold the key
  double weight_kg = 0.0;             // 0: none
  int lifts = 4;                      // of the weight, 3 or more
  const std::atomic<bool>* stop = nullptr;
  PushLimits limits;
};

struct ForceObservations {
  std::vector<ForcePose> poses;
  std::vector<double> rising, sinking;  // N, of the weight
  std::array<int, kBreakOffs> break_offs{};
  std::string ramps_csv;  // each ramp's response, for provenance
};

Expected<ForceObservations> observe_forces(device::ArmDevice& arm, const rig::Rig& rig,
                                           Clock<PhysicsClock>& clock, ForcePerson& person,
                                           const ForceSessionSettings& settings = {});

}  // namespace palpate::calibration::forces
