// The sacred millisecond: read the arm, know the tip, feel the contact, limit, command, publish.
//
// Forces come in World axes and leave in ArmBase axes. tick() is called by the haptic thread at a fixed rate,
// or by a test; after construction it does not allocate, lock, throw or write text. Input and output are
// triple buffers: one other thread (physics) writes the input and reads the tip. A fault is a state
// (ForceFault): forces fade, and the last seconds are kept in records().
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/devices/devices.h"
#include "palpate/haptics/contact_player.h"
#include "palpate/haptics/force_limiter.h"
#include "palpate/haptics/tip_filter.h"
#include "palpate/model/rig.h"
#include "palpate/scene/application.h"
#include "palpate/time/triple_buffer.h"

namespace palpate {

// What the physics loop tells the haptic loop, every step.
struct HapticInput {
  ContactEvent contact;                 // the newest blow
  Vector3 sustained = Vector3::Zero();  // N on the hand, World; not a blow
};

// From an application's step: while a blow is under way the state's force shows that blow and is not asked
// for twice.
inline HapticInput haptic_input(const WorldState& state, const ContactEvent& contact) {
  const bool blow = contact.number != 0 && state.contact > 0.0;
  return {contact, blow ? Vector3::Zero() : Vector3(state.force.data())};
}

struct HapticSettings {
  Duration period{1'000'000};
  ForceLimits limits;
  double record_s = 5.0;  // kept for inspection
};

struct HapticStatistics {
  std::uint64_t ticks = 0, limited_ticks = 0, blows = 0, rejected_blows = 0, fault_ticks = 0, bad_samples = 0;
  double peak_n = 0.0;
  double impulse_asked = 0.0, impulse_lost = 0.0;  // N s, of blows that have ended
  double impulse_error_rel_max = 0.0;  // |delivered - asked| / asked, worst blow (overlapping ones together)
  double lost_impulse_rel() const { return impulse_asked > 0.0 ? impulse_lost / impulse_asked : 0.0; }
};

struct HapticRecord {
  Instant<PhysicsClock> time;
  Vector3 joints, tip, asked, commanded;  // rad; m, N in World; N in ArmBase
  ForceFault fault = ForceFault::none;
};

class HapticLoop {
 public:
  // The references must outlive the loop. Throws std::invalid_argument for settings that cannot be.
  HapticLoop(ArmDevice& arm, const ArmCalibration& calibration, const PhantomLengths& nominal,
             const HapticSettings& settings, TripleBuffer<HapticInput>& input,
             TripleBuffer<TipState>& output);

  void tick(Instant<PhysicsClock> now);
  void rearm() { limiter_.rearm(); }  // by the haptic thread

  const TipState& tip() const { return tip_; }
  const HapticStatistics& statistics() const { return statistics_; }
  ForceFault fault() const { return limiter_.fault(); }
  // Oldest first. Allocates: after the loop has stopped, or between ticks of a test.
  std::vector<HapticRecord> records() const;

 private:
  void listen(Instant<PhysicsClock> now);
  void account();
  Vector3 device_force(const Vector3& world) const;

  ArmDevice& arm_;
  ArmCalibration calibration_;
  PhantomLengths nominal_;
  HapticSettings settings_;
  TripleBuffer<HapticInput>& input_;
  TripleBuffer<TipState>& output_;
  TipFilter filter_;
  ContactPlayer player_;
  ForceLimiter limiter_;
  HapticInput newest_;
  TipState tip_;
  bool started_ = false, sampled_ = false, heard_ = false;
  Instant<PhysicsClock> last_tick_, last_sample_, last_heard_;
  Vector3 joints_ = Vector3::Zero(), theta_ = Vector3::Zero();  // of the last usable sample
  Vector3 asked_before_ = Vector3::Zero(),
          delivered_before_ = Vector3::Zero();  // when the last blow had settled
  HapticStatistics statistics_;
  std::vector<HapticRecord> ring_;
};

}  // namespace palpate
