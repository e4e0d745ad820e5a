// What has a millisecond, as its real-time deadline: read the arm, know the tip, feel the contact, limit,
// command, publish.
//
// Forces come in World axes and leave in ArmBase axes, through the chain of docs/theory/forces.md: impacts
// played by time and the continuous force with the damping that keeps it passive; gain; the limiter under
// peak, slew and the motors' heat; the device's own kinematics; the last clamp. What may be given at all the
// guard says. tick() is called by the haptic thread at a fixed rate, or by a test; after construction it does
// not allocate, lock, throw or write text. Input and output are triple buffers: one other thread (physics)
// writes the input and reads the tip. condition() and records() are for any thread.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "palpate/device/devices.h"
#include "palpate/haptics/arm_force.h"
#include "palpate/haptics/force_guard.h"
#include "palpate/haptics/force_limiter.h"
#include "palpate/haptics/haptic_record.h"
#include "palpate/haptics/impact_renderer.h"
#include "palpate/haptics/last_clamp.h"
#include "palpate/haptics/motor_heat.h"
#include "palpate/haptics/passivity.h"
#include "palpate/haptics/tip_filter.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/time/triple_buffer.h"

namespace palpate::haptics {

// What the physics loop tells the haptic loop, every step.
struct HapticInput {
  scene::ImpactEvent impact;             // the newest
  Vector3 continuous = Vector3::Zero();  // N on the hand, World; not an impact
  Instant<PhysicsClock> time;            // of the state this comes from: where it stands still, physics does
  // The impacts before the newest, newest first: where a tick comes late, none is missed.
  std::array<scene::ImpactEvent, 3> earlier{};
};

// From an application's step; `before` is the input of the step before.
inline HapticInput haptic_input(const scene::SceneState& state, const scene::ImpactEvent& impact,
                                const HapticInput& before) {
  HapticInput input{impact, Vector3(state.continuous.force.data()), state.time, before.earlier};
  if (impact.number != before.impact.number)
    input.earlier = {before.impact, before.earlier[0], before.earlier[1]};
  return input;
}

struct HapticSettings {
  Duration period{1'000'000};
  ForceLimits limits;
  double force_gain = 1.0;  // of every force requested, 0 ... 1
  double record_s = 5.0;    // kept for inspection; at most HapticRecords::capacity() ticks
};

struct HapticStatistics {
  // limited: another force was given than requested; peak_limited: of these, where the peak cut it. The
  // others could not rise or fall as quickly, paid back what was held off, or faded.
  std::uint64_t ticks = 0, limited_ticks = 0, peak_limited_ticks = 0, fault_ticks = 0, bad_samples = 0,
                damped_ticks = 0, warm_ticks = 0;
  std::uint64_t outages = 0;  // brief ones (ForceStrength): forces came back to what there was
  // missed: so many came between two ticks that their numbers alone are known. dropped: in the backlog from
  // before an outage, or come too late.
  std::uint64_t impacts = 0, rejected_impacts = 0, missed_impacts = 0, dropped_impacts = 0;
  double peak_n = 0.0;
  double impulse_requested = 0.0, impulse_lost = 0.0;  // N s, of impacts that have ended; what the device
                                                       // withheld
                                                       // meanwhile (ArmSample::withheld) is lost, too
  double impulse_error_rel_max = 0.0;  // |delivered - requested| / requested, worst impact (overlapping ones
                                       // together)
  double lost_impulse_rel() const { return impulse_requested > 0.0 ? impulse_lost / impulse_requested : 0.0; }
};

// How the loop is doing, for other threads.
struct HapticCondition {
  HapticState state = HapticState::ready;
  ForceFault fault = ForceFault::none;
  std::uint64_t ticks = 0;
  // A trip: forces were on and a fault took them, or it made the state safe.
  std::uint64_t trips = 0, trip_tick = 0;    // the newest trip's tick
  ForceFault trip_fault = ForceFault::none;  // and its reason
};

class HapticLoop {
 public:
  // The references must outlive the loop. Throws std::invalid_argument for settings that cannot be.
  HapticLoop(device::ArmDevice& arm, const rig::ArmCalibration& calibration,
             const device::PhantomLengths& nominal, const HapticSettings& settings,
             TripleBuffer<HapticInput>& input, TripleBuffer<scene::TipState>& output);

  void tick(Instant<PhysicsClock> now);
  bool rearm() { return guard_.rearm(); }  // by the haptic thread; ForceGuard::rearm()

  // Haptic thread, or after it has stopped.
  const scene::TipState& tip() const { return tip_; }
  const HapticStatistics& statistics() const { return statistics_; }
  ForceFault fault() const { return guard_.fault(); }
  HapticState state() const { return guard_.state(); }

  // Any thread. Nothing before the first tick.
  HapticCondition condition() const { return condition_.newest().value_or(HapticCondition{}); }
  // The last record_s seconds, oldest first. Allocates.
  std::vector<HapticRecord> records() const { return records_before(records_->count()); }
  // Those that ended with this tick (counted from 1), as far as they are still there.
  std::vector<HapticRecord> records_before(std::uint64_t tick) const;

 private:
  static constexpr double kUnlimited = std::numeric_limits<double>::infinity();

  void read_arm(Instant<PhysicsClock> now, SafetyInputs& inputs);
  void follow_tip(Instant<PhysicsClock> now, const device::ArmSample& sample);
  double held_share(const device::ArmSample& sample, double elapsed) const;
  void let_go(double held);
  void limit_return(double elapsed, bool late, double continuous_before, double continuous_asked);
  void note_withheld(const Vector3& withheld);
  void listen(Instant<PhysicsClock> now, SafetyInputs& inputs);
  void begin_impacts(std::uint64_t after, Instant<PhysicsClock> now);
  RequestedForce requested_force(Instant<PhysicsClock> now);
  void account(double elapsed);
  void keep(Instant<PhysicsClock> now, const RequestedForce& requested, ForceFault before,
            double gain_before);

  device::ArmDevice& arm_;
  rig::ArmCalibration calibration_;
  device::PhantomLengths nominal_;
  HapticSettings settings_;
  double period_;
  TripleBuffer<HapticInput>& input_;
  TripleBuffer<scene::TipState>& output_;

  TipFilter filter_;
  ImpactRenderer player_;
  PassivityObserver passivity_;
  ForceGuard guard_;
  ForceLimiter limiter_;
  MotorHeat heat_;
  LastClamp clamp_;

  HapticInput newest_;
  scene::TipState tip_;
  bool started_ = false, sampled_ = false, heard_ = false;
  Instant<PhysicsClock> last_tick_, last_fresh_sample_;
  Instant<ArmClock> last_stamp_;
  Vector3 joints_ = Vector3::Zero(),
          moved_ = Vector3::Zero();  // last reading; the tip's way since the tick before
  DeviceForce device_;               // at the last pose that had one
  Vector3 requested_before_ = Vector3::Zero(),
          delivered_before_ = Vector3::Zero();  // when the last impact had settled
  Vector3 device_withheld_ = Vector3::Zero(),   // as last read: N s, device's axes
      withheld_ = Vector3::Zero();              // of the impacts not yet accounted for: N s, World
  double settled_s_ = 0.0;
  bool interrupted_ = true;              // an outage was under way at the tick before
  double most_continuous_ = kUnlimited;  // N, after a brief outage
  HapticStatistics statistics_;
  HapticCondition told_;
  Mailbox<HapticCondition> condition_;
  std::unique_ptr<HapticRecords> records_;
};

}  // namespace palpate::haptics
