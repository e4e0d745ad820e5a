// What has a millisecond, as its real-time deadline: read the arm, know the tip, feel the contact, limit,
// command, publish.
//
// The continuous force is what the application's contact law says of the tip just read, or, where it has none,
// what its step has said; impacts are its events. Forces come in World axes and leave in ArmBase axes, through the chain of docs/theory/forces.md: impacts
// played by time and the continuous force with the damping that keeps it passive; gain; the limiter under
// peak, slew and the motors' heat; the device's own kinematics; the last clamp. What may be given at all the
// guard says. tick() is called by the haptic thread at a fixed rate, or by a test; after construction it does
// not allocate, lock, throw or write text. Input and output are triple buffers: one other thread (physics)
// writes the input and reads the tip. What is const is for any thread; all else is the haptic thread's.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/guest_call.h"
#include "palpate/device/devices.h"
#include "palpate/haptics/arm_force.h"
#include "palpate/haptics/force_guard.h"
#include "palpate/haptics/force_limiter.h"
#include "palpate/haptics/force_permit.h"
#include "palpate/haptics/guest.h"
#include "palpate/haptics/guest_watch.h"
#include "palpate/haptics/haptic_record.h"
#include "palpate/haptics/haptic_tick.h"
#include "palpate/haptics/impact_renderer.h"
#include "palpate/haptics/last_clamp.h"
#include "palpate/haptics/motor_heat.h"
#include "palpate/haptics/passivity.h"
#include "palpate/haptics/tip_filter.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/time/delay_line.h"
#include "palpate/time/triple_buffer.h"

namespace palpate::haptics {

// What the physics loop tells the haptic loop, every step.
struct HapticInput {
  scene::ImpactEvent impact;             // the newest
  Vector3 continuous = Vector3::Zero();  // N on the hand, World; counts where there is no contact law
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

// The same so much later: an impact is played whole and in its place.
inline HapticInput later(HapticInput input, Duration by) {
  input.impact.start += by;
  for (auto& impact : input.earlier) impact.start += by;
  input.time += by;
  return input;
}

// Code of others that the tick calls or listens to.
struct HapticGuests {
  std::string application;             // its name
  scene::ContactLaw* law = nullptr;    // null: it has none
  const ThreadClock* clock = nullptr;  // what they take; null, in lock-step: a tick takes no time
};

struct HapticSettings {
  Duration period{1'000'000};
  ForceLimits limits;
  ForcePermit permit;       // none: no force, whatever is requested
  bool armed = true;        // false: no force before the first rearm()
  double force_gain = 1.0;  // of every force requested, 0 ... 1
  double record_s = 5.0;    // kept for inspection; at most HapticRecords::capacity() ticks
};

struct HapticStatistics {
  // limited: another force was given than requested; peak_limited: of these, where the peak cut it. The
  // others could not rise or fall as quickly, paid back what was held off, or faded. fault: 0 N was commanded
  // through a fault.
  std::uint64_t ticks = 0, limited_ticks = 0, peak_limited_ticks = 0, fault_ticks = 0, bad_samples = 0,
                damped_ticks = 0, warm_ticks = 0;
  std::uint64_t outages = 0;  // brief ones (ForceStrength): forces came back to what there was
  // missed: so many came between two ticks that their numbers alone are known. dropped: in the backlog from
  // before an outage, or come too late.
  std::uint64_t impacts = 0, rejected_impacts = 0, missed_impacts = 0, dropped_impacts = 0;
  // Of the contact law: calls; those that were too slow; forces that were none, or beyond its promise.
  std::uint64_t law_ticks = 0, law_overruns = 0, law_bad_forces = 0;
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
  ForceState state = ForceState::ready;
  ForceFault fault = ForceFault::none;
  Guest culprit = Guest::none;  // of the fault
  std::uint64_t ticks = 0;
  std::uint64_t trips = 0, trip_tick = 0;    // HapticTrip: how many; the newest one's tick
  ForceFault trip_fault = ForceFault::none;  // and its reason
  Guest trip_culprit = Guest::none;
};

class HapticLoop {
 public:
  // References and guests must outlive the loop. `nominal` counts where the device takes forces. Throws
  // std::invalid_argument for settings that cannot be, for a law that promises nothing, and for an arm that
  // does not go with its calibration.
  HapticLoop(device::ArmDevice& arm, const rig::ArmCalibration& calibration, const device::ArmModel& nominal,
             const HapticSettings& settings, TripleBuffer<HapticInput>& input,
             TripleBuffer<scene::TipState>& output, const HapticGuests& guests = {});

  // `told`, where it is asked for: what happened in it.
  void tick(Instant<PhysicsClock> begun, HapticTick* told = nullptr);
  // By the haptic thread; ForceGuard::rearm(). A law that was switched off is on again.
  bool rearm();
  // Before the first tick: the law's force comes so much later (experiments).
  void delay_law(Duration delay) { law_delay_.set(delay); }

  // Haptic thread, or after it has stopped. Whoever else looks on has the loop as const, and its condition() and records().
  const scene::TipState& tip() { return tip_; }
  const HapticStatistics& statistics() { return statistics_; }
  ForceFault fault() { return guard_.fault(); }
  ForceState state() { return guard_.state(); }
  const JitterHistogram& law_cost() { return law_watch_.cost(); }

  // Any thread: whether the arm may have forces at all; it does not change.
  const ForcePermit& permit() const { return settings_.permit; }
  const ForceLimits& limits() const { return settings_.limits; }  // the same

  // Any thread, also while a tick hangs, and a signal handler: the arm lets go; the next tick that comes begins
  // with no force and follows the rule for every return of force.
  void let_go() noexcept {
    let_go_.store(true);
    arm_.let_go();
  }
  Guest busy_with() const { return busy_with_.load(std::memory_order_relaxed); }  // in the tick under way
  std::uint64_t ticks_ended() const { return ticks_ended_.load(std::memory_order_relaxed); }
  std::string name_of(Guest guest) const { return haptics::name_of(guest, guests_.application); }

  // Any thread. Nothing before the first tick.
  HapticCondition condition() const { return condition_.newest().value_or(HapticCondition{}); }
  // The last record_s seconds, oldest first. Allocates.
  std::vector<HapticRecord> records() const { return records_before(records_->count()); }
  // Those that ended with this tick (counted from 1), as far as they are still there.
  std::vector<HapticRecord> records_before(std::uint64_t tick) const;
  // The same one by one: record k of tick k + 1, and trips 0, 1, ...; nothing where it has been overwritten.
  std::uint64_t record_count() const { return records_->count(); }
  std::optional<HapticRecord> record(std::uint64_t k) const { return records_->read(k); }
  std::uint64_t trip_count() const { return trips_->count(); }
  std::optional<HapticTrip> trip(std::uint64_t k) const {
    HapticTrip trip;
    return trips_->read(k, trip) ? std::optional(trip) : std::nullopt;
  }

 private:
  static constexpr double kUnlimited = std::numeric_limits<double>::infinity();

  template <typename Call>
  void visit(Guest guest, GuestWatch& watch, Call&& call);
  device::ArmSample read_arm();
  void command_arm(const Vector3& force);
  void feel_law(Instant<PhysicsClock> now);
  Duration held_up();
  void take_reading(Instant<PhysicsClock> now, const device::ArmSample& sample, SafetyInputs& inputs);
  void judge_guests(SafetyInputs& inputs);
  Guest culprit() const;
  bool is_fresh(Instant<PhysicsClock> now, Instant<ArmClock> stamp);
  void follow_tip(Instant<PhysicsClock> now, const device::ArmSample& sample);
  double held_share(const device::ArmSample& sample, double elapsed, bool held_up) const;
  void let_go(double held);
  void limit_return(double elapsed, bool late, double continuous_before, double continuous_asked);
  void note_withheld(const Vector3& withheld);
  void listen(Instant<PhysicsClock> now, SafetyInputs& inputs);
  void begin_impacts(std::uint64_t after, Instant<PhysicsClock> now);
  RequestedForce requested_force(Instant<PhysicsClock> now);
  void account(double elapsed);
  void keep(Instant<PhysicsClock> now, const RequestedForce& requested, ForceFault before,
            double gain_before);
  void tell(HapticTick& told, const device::ArmSample& sample, const RequestedForce& requested) const;

  device::ArmDevice& arm_;
  rig::ArmCalibration calibration_;
  std::unique_ptr<const device::ArmKinematics> kinematics_, nominal_;
  device::JointMotors* motors_;  // null: the device takes forces
  device::JointVector torque_limits_;
  HapticSettings settings_;
  double period_;
  HapticGuests guests_;
  std::array<std::string, 4> guest_words_;  // by Guest
  double law_bound_n_ = 0.0;
  TripleBuffer<HapticInput>& input_;
  TripleBuffer<scene::TipState>& output_;

  TipFilter filter_;
  ImpactRenderer player_;
  PassivityObserver passivity_;
  ForceGuard guard_;
  ForceLimiter limiter_;
  MotorHeat heat_;
  LastClamp clamp_;
  GuestWatch law_watch_, arm_watch_;
  DelayLine<Vector3> law_delay_;

  HapticInput newest_;
  scene::TipState tip_;
  bool started_ = false, sampled_ = false, heard_ = false;
  Instant<PhysicsClock> last_tick_, last_fresh_sample_;
  Instant<ArmClock> last_stamp_;
  std::optional<Instant<PhysicsClock>> went_back_;  // the stamps did, last
  device::JointVector joints_;                      // last reading
  Vector3 moved_ = Vector3::Zero();                 // the tip's way since the tick before
  DeviceForce device_;                              // at the last pose that had one
  Vector3 requested_before_ = Vector3::Zero(),
          delivered_before_ = Vector3::Zero();  // when the last impact had settled
  Vector3 device_withheld_ = Vector3::Zero(),   // as last read: N s, device's axes
      withheld_ = Vector3::Zero();              // of the impacts not yet accounted for: N s, World
  double settled_s_ = 0.0;
  bool interrupted_ = true;              // an outage was under way at the tick before
  double most_continuous_ = kUnlimited;  // N, after a brief outage
  HapticStatistics statistics_;
  Vector3 law_force_ = Vector3::Zero(), law_due_ = Vector3::Zero();  // of this tick; what the delay gave last
  Duration arm_took_{0}, law_took_{0};                               // in this tick, before the command
  bool law_off_ = false, law_erred_ = false, arm_threw_ = false;
  Guest slowest_ = Guest::none;  // who held this tick up
  std::atomic<bool> let_go_{false};
  std::atomic<Guest> busy_with_{Guest::none};
  std::atomic<std::uint64_t> ticks_ended_{0};
  HapticCondition told_;
  Mailbox<HapticCondition> condition_;
  std::unique_ptr<HapticRecords> records_;
  std::unique_ptr<BroadcastRing<HapticTrip, 256>> trips_;
};

}  // namespace palpate::haptics
