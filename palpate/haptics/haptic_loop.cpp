#include "palpate/haptics/haptic_loop.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate::haptics {
namespace {

HapticSettings checked(const HapticSettings& settings) {
  if (settings.period <= Duration(0)) throw std::invalid_argument("haptic loop: the period must be > 0");
  if (!(settings.force_gain >= 0.0 && settings.force_gain <= 1.0))
    throw std::invalid_argument(
        fmt::format("haptic loop: force_gain is {}, expected 0 ... 1", settings.force_gain));
  if (!(settings.record_s >= 0.0))
    throw std::invalid_argument(fmt::format("haptic loop: record_s is {}, expected >= 0", settings.record_s));
  check_force_limits(settings.limits);
  HapticSettings within = settings;
  within.limits = settings.permit.lowered(settings.limits);
  return within;
}

HapticGuests checked(const HapticGuests& guests) {
  if (guests.law == nullptr) return guests;
  const double most = guests.law->force_bound();
  if (!(most > 0.0 && std::isfinite(most)))
    throw std::invalid_argument(fmt::format(
        "{}: the contact law promises {} N at most; a force above 0 is expected", guests.application, most));
  if (guests.law->cost_bound() <= Duration(0))
    throw std::invalid_argument(
        fmt::format("{}: the contact law promises to take {} ns at most; more than 0 is expected",
                    guests.application, guests.law->cost_bound().count()));
  return guests;
}

void check_joints(const rig::ArmCalibration& arm, const device::ArmKinematics& nominal,
                  const device::JointVector* torque_limits) {
  const Eigen::Index joints = arm.model.joint_count();
  const auto demand = [&](Eigen::Index there, const char* what) {
    if (there != joints)
      throw std::invalid_argument(fmt::format("haptic loop: the arm {} has {} joints, {} has {}",
                                              arm.model.name, joints, what, there));
  };
  demand(arm.correction.gain.size(), "its gains' list");
  demand(arm.correction.offset.size(), "its offsets' list");
  demand(nominal.joint_count(), "its nominal kinematics");
  if (torque_limits == nullptr) return;
  demand(torque_limits->size(), "the list of its motors' limits");
  if (!(torque_limits->minCoeff() > 0.0) || !torque_limits->allFinite())
    throw std::invalid_argument(
        fmt::format("haptic loop: a motor of the arm {} is said to give {} N m; more than 0 is expected",
                    arm.model.name, torque_limits->minCoeff()));
}

// What read() and command() take is microseconds: a driver that waits for its device does not belong there.
constexpr Duration kMostOfTheArm = std::chrono::milliseconds(2);

Duration law_bound(const HapticGuests& guests, Duration period) {
  return guests.law == nullptr ? period : std::min(guests.law->cost_bound(), period / 2);
}

}  // namespace

HapticLoop::HapticLoop(device::ArmDevice& arm, const rig::ArmCalibration& calibration,
                       const device::ArmModel& nominal, const HapticSettings& settings,
                       TripleBuffer<HapticInput>& input, TripleBuffer<scene::TipState>& output,
                       const HapticGuests& guests)
    : arm_(arm),
      calibration_(calibration),
      kinematics_(device::make_kinematics(calibration.model)),
      nominal_(device::make_kinematics(nominal)),
      motors_(arm.motors()),
      torque_limits_(motors_ == nullptr ? device::JointVector() : motors_->limits()),
      settings_(checked(settings)),
      period_(to_seconds(settings.period)),
      guests_(checked(guests)),
      guest_words_{"", name_of(Guest::application), name_of(Guest::contact_law), name_of(Guest::arm)},
      law_bound_n_(guests.law == nullptr ? 0.0 : guests.law->force_bound()),
      input_(input),
      output_(output),
      passivity_(settings_.limits.most_damping_n_s_m),
      guard_(settings_.limits, settings_.permit.given(), settings_.armed),
      limiter_(settings_.limits.max_backlog_s),
      heat_(settings_.limits),
      clamp_(settings_.limits, period_),
      law_watch_(law_bound(guests, settings.period), guests.clock),
      arm_watch_(kMostOfTheArm, guests.clock),
      records_(std::make_unique<HapticRecords>()),
      trips_(std::make_unique<BroadcastRing<HapticTrip, 256>>()) {
  check_joints(calibration_, *nominal_, motors_ == nullptr ? nullptr : &torque_limits_);
  joints_ = device::JointVector::filled(kinematics_->joint_count(), 0.0);
  // No torques until there was a pose that has some.
  device_.J = device::TipJacobian::Zero(3, kinematics_->joint_count());
  told_.state = guard_.state();
  told_.fault = guard_.fault();
  condition_.write(told_);
}

void HapticLoop::tick(Instant<PhysicsClock> begun, HapticTick* told) {
  SafetyInputs inputs;
  const double continuous_before = limiter_.continuous().norm();
  const Matrix3 M_before = device_.M;
  const device::ArmSample sample = read_arm();
  take_reading(begun, sample, inputs);
  feel_law(begun);
  // Where a guest has held the tick up, it begins anew when that is over: what was known is old.
  const Duration waited = held_up();
  const Instant<PhysicsClock> now = begun + waited;
  const bool let_go_meanwhile = InputTrace::pass(let_go_.exchange(false)) != 0;
  double elapsed = started_ ? std::max(0.0, to_seconds(now - last_tick_)) : 0.0;
  if (let_go_meanwhile) elapsed = std::max(elapsed, to_seconds(device::kLongestHold));
  last_tick_ = now;
  started_ = true;
  inputs.elapsed_s = elapsed;
  inputs.held = let_go_meanwhile ? 0.0 : held_share(sample, elapsed, waited > Duration(0));
  inputs.reading_age_s =
      sampled_ ? to_seconds(now - last_fresh_sample_) : std::numeric_limits<double>::infinity();
  inputs.clamp_good = !clamp_.tripped();
  inputs.button_held = settings_.permit.held(sample.buttons);
  judge_guests(inputs);
  const bool late = !(elapsed < settings_.limits.stale_s);
  if (late) statistics_.dropped_impacts += static_cast<std::uint64_t>(player_.drop());
  listen(now, inputs);
  RequestedForce requested = requested_force(now);
  inputs.requested_good = requested.good() && !law_erred_;
  if (!inputs.requested_good) requested = RequestedForce{};
  const double held_s =
      late && inputs.held < 1.0 ? std::min(elapsed, to_seconds(device::kLongestHold)) : elapsed;
  heat_.held(clamp_.last().norm(), held_s);
  if (held_s < elapsed) heat_.held(0.0, elapsed - held_s);
  inputs.warm = heat_.warm();

  const ForceFault before = guard_.fault();
  const double gain_before = guard_.gain();
  guard_.tick(inputs);
  const device::ForceStrength& strength = guard_.strength();
  if (strength.out()) statistics_.dropped_impacts += static_cast<std::uint64_t>(player_.drop());
  if (late) let_go(inputs.held);
  limit_return(elapsed, late, continuous_before, requested.continuous.norm());

  // The device's force is M f. That it stays within the device's limits while M changes is the limiter's
  // room.
  const Quaternion R_base_world = calibration_.X_world_base.rotation.conjugate();
  const double turned = ((device_.M - M_before) * (R_base_world * limiter_.held())).norm();
  const AvailableForce available{
      .peak = std::min(heat_.allowed_n() / std::max(1.0, device_.gain), device_.most_n),
      .step = (settings_.limits.slew_n_s * period_ - turned) / std::max(1.0, device_.gain),
      .gain = guard_.gain(),
      .fading = strength.out(),
      .drop_backlog = late,
      .most_continuous = strength.share() * most_continuous_};
  const bool interrupted =
      late || strength.out();  // what the hand did meanwhile no force of ours answered to
  const bool touching =
      !interrupted && (requested.continuous != Vector3::Zero() || limiter_.continuous() != Vector3::Zero());
  passivity_.moved(limiter_.continuous(), moved_, touching);
  RequestedForce damped = requested;
  if (touching) damped.continuous += passivity_.damping(tip_.velocity, period_);
  const Vector3 force = limiter_.tick(damped, available, held_s, period_);
  command_arm(clamp_.pass(device_.M * (R_base_world * force)));
  if (inputs.reading_good) output_.write(tip_);

  account(elapsed);
  keep(now, requested, before, gain_before);
  if (told != nullptr) {
    told->begun = begun;
    tell(*told, sample, requested);
  }
  ticks_ended_.store(statistics_.ticks, std::memory_order_relaxed);
}

bool HapticLoop::rearm() {
  if (!guard_.rearm()) return false;
  law_off_ = false;
  law_watch_.forgive();
  return true;
}

// Where the reading makes no sense the last good tip stays, and the last way from force to device.
void HapticLoop::take_reading(Instant<PhysicsClock> now, const device::ArmSample& sample,
                              SafetyInputs& inputs) {
  const bool complete = sample.joints.size() == kinematics_->joint_count();
  const device::JointVector theta =
      complete ? calibration_.correction.apply(sample.joints) : device::JointVector();
  inputs.connected = sample.connected;
  inputs.reading_good = complete && theta.allFinite() && sample.gimbal.allFinite();
  joints_ = sample.joints;
  if (motors_ == nullptr) note_withheld(sample.withheld);
  moved_.setZero();
  if (inputs.reading_good) {
    const Vector3 gimbal = calibration_.gimbal_gain.cwiseProduct(sample.gimbal) + calibration_.gimbal_offset;
    const Vector3 place = tip_.X_world_tip.translation;
    tip_.time = now - sample.waited;
    const auto [X_base_tip, J] = kinematics_->pose_and_jacobian(theta, gimbal);
    tip_.X_world_tip = calibration_.X_world_base * X_base_tip;
    if (sampled_) moved_ = tip_.X_world_tip.translation - place;
    follow_tip(now, sample);
    const auto device = motors_ == nullptr ? DeviceForce::at(sample.joints, *nominal_, J, *kinematics_)
                                           : DeviceForce::through_motors(J, *kinematics_, torque_limits_);
    if (device) device_ = *device;
    inputs.inside_workspace = device.has_value();
    for (int i = 0; i < kinematics_->joint_count(); ++i) {
      const auto& [low, high] = settings_.limits.joint_range[static_cast<std::size_t>(i)];
      inputs.inside_workspace = inputs.inside_workspace && theta[i] >= low && theta[i] <= high;
    }
  } else {
    ++statistics_.bad_samples;
  }
  inputs.tip_speed = tip_.velocity.norm();
}

// Whether this reading is later than the last one by the device's own stamps. Stamps that run backwards tell of
// the past, or of a device that has begun anew: what they belong to counts only once they have gone forward for a
// while.
bool HapticLoop::is_fresh(Instant<PhysicsClock> now, Instant<ArmClock> stamp) {
  if (!sampled_) return true;
  if (stamp <= last_stamp_) {
    if (last_stamp_ - stamp > settings_.period) {
      last_stamp_ = stamp;
      went_back_ = now;
    }
    return false;
  }
  constexpr Duration kForward = std::chrono::milliseconds(50);
  if (went_back_ && now - *went_back_ < kForward) {
    last_stamp_ = stamp;
    return false;
  }
  went_back_.reset();
  return true;
}

// The velocity, by time: a reading that is not new says nothing of it, and one after a gap says its mean. By
// the device's own stamps, which tell when it measured; where they make no sense, by this host's time.
void HapticLoop::follow_tip(Instant<PhysicsClock> now, const device::ArmSample& sample) {
  if (!is_fresh(now, sample.stamp)) return;
  const Instant<PhysicsClock> measured = now - sample.waited;
  const double by_host = to_seconds(measured - last_fresh_sample_),
               by_device = to_seconds(sample.stamp - last_stamp_);
  const double slack = 2.0 * period_;  // either end may have been read so much later than measured
  const bool plausible = by_device > 0.0 && std::abs(by_device - by_host) <= slack;
  const double since = plausible ? by_device : by_host;
  if (!sampled_ || since > 0.0) filter_.update(tip_.X_world_tip, since);
  tip_.velocity = filter_.velocity();
  tip_.angular_velocity = filter_.angular_velocity();
  last_stamp_ = sample.stamp;
  last_fresh_sample_ = measured;
  sampled_ = true;
}

// The share of the last command that the device still gives after the loop has stood still for `elapsed`.
// Where the tick was held up, what the device said before that is old.
double HapticLoop::held_share(const device::ArmSample& sample, double elapsed, bool held_up) const {
  const Vector3& told = clamp_.last();
  if (told == Vector3::Zero()) return 1.0;
  if (!sample.held || motors_ != nullptr || held_up)
    return elapsed < to_seconds(device::kLongestHold) ? 1.0 : 0.0;
  const double share = sample.held->dot(told) / told.squaredNorm();
  return share >= 0.0 ? std::min(share, 1.0) : 0.0;  // what is no number counts as let go
}

void HapticLoop::let_go(double held) {
  clamp_.let_go(held);
  limiter_.let_go(held);
}

// After a brief outage the continuous force comes back to what was held, and from there on rises no faster
// than the start ramp would: the hand may have sunk in meanwhile. Once no more is requested, the limit is
// over.
void HapticLoop::limit_return(double elapsed, bool late, double continuous_before, double continuous_asked) {
  const device::ForceStrength& strength = guard_.strength();
  const bool out = strength.out();
  if (!interrupted_ && (out || late)) most_continuous_ = continuous_before;
  const bool ended = !out && (interrupted_ || late);
  interrupted_ = out;
  if (out) return;
  if (ended) {
    if (!strength.brief()) most_continuous_ = kUnlimited;
    statistics_.outages += strength.brief() && strength.outage_s() > 0.0;
    return;
  }
  constexpr double kHeldFor = 0.050;  // s: within it there is never more than was held before
  if (strength.good_s() < kHeldFor) return;
  const double ramp_s = settings_.limits.start_ramp_s;
  most_continuous_ += ramp_s > 0.0 ? elapsed / ramp_s * settings_.limits.peak_n : kUnlimited;
  if (strength.gain() * continuous_asked <= most_continuous_) most_continuous_ = kUnlimited;
}

// Counts for the impacts on their way, all of it: what else was held then is not told apart.
void HapticLoop::note_withheld(const Vector3& withheld) {
  if (!withheld.allFinite()) return;
  const Vector3 change = withheld - device_withheld_;
  device_withheld_ = withheld;
  if (player_.requested() == requested_before_) return;
  const Vector3 felt = device_.M.partialPivLu().solve(change);
  withheld_ += calibration_.X_world_base.rotation * felt;
}

void HapticLoop::listen(Instant<PhysicsClock> now, SafetyInputs& inputs) {
  HapticInput said;
  if (input_.read(said) && (!heard_ || said.time > newest_.time)) {
    const std::uint64_t before = newest_.impact.number;
    const bool first = !heard_;
    newest_ = said;
    heard_ = true;
    // What went before the first word is nobody's to feel.
    begin_impacts(first && !said.impact.none() ? said.impact.number - 1 : before, now);
  }
  inputs.input_age_s = heard_ ? to_seconds(now - newest_.time) : std::numeric_limits<double>::infinity();
}

// Those of the newest input that are newer than number `after`, oldest first.
void HapticLoop::begin_impacts(std::uint64_t after, Instant<PhysicsClock> now) {
  const auto begin = [&](const scene::ImpactEvent& impact) {
    const bool too_late = impact.start < now - seconds(settings_.limits.stale_s);
    if (too_late)
      ++(player_.skip(impact, now) ? statistics_.dropped_impacts : statistics_.rejected_impacts);
    else
      ++(player_.start(impact, now) ? statistics_.impacts : statistics_.rejected_impacts);
  };
  const scene::ImpactEvent& newest = newest_.impact;
  if (newest.number == after || newest.none()) return;
  std::uint64_t seen = after;
  const auto missed = [&](std::uint64_t number) {
    if (number > seen + 1) statistics_.missed_impacts += number - seen - 1;
    seen = number;
  };
  for (auto impact = newest_.earlier.rbegin(); impact != newest_.earlier.rend(); ++impact) {
    if (impact->number <= seen || impact->number >= newest.number) continue;
    missed(impact->number);
    begin(*impact);
  }
  missed(newest.number);
  begin(newest);
}

RequestedForce HapticLoop::requested_force(Instant<PhysicsClock> now) {
  RequestedForce requested;
  requested.continuous = settings_.force_gain * (guests_.law != nullptr ? law_force_ : newest_.continuous);
  requested.impact = settings_.force_gain * player_.tick(now, settings_.period);
  requested.impact_active = player_.active();
  requested.impact_to_come = settings_.force_gain * player_.to_come();
  return requested;
}

// Compares what was requested with what was given each time the hand has come to rest between impacts, and
// the device has had time to tell what it made of the last force.
void HapticLoop::account(double elapsed) {
  settled_s_ = player_.active() || !limiter_.settled() ? 0.0 : settled_s_ + elapsed;
  constexpr double kDeviceTells = 0.005;  // s
  if (settled_s_ < kDeviceTells || player_.requested() == requested_before_) return;
  const Vector3 requested = settings_.force_gain * (player_.requested() - requested_before_);
  const double missing = (requested - (limiter_.delivered() - delivered_before_ - withheld_)).norm();
  statistics_.impulse_requested += requested.norm();
  statistics_.impulse_lost += missing;
  if (requested.norm() > 0.0) {
    statistics_.impulse_error_rel_max =
        std::max(statistics_.impulse_error_rel_max, missing / requested.norm());
  }
  requested_before_ = player_.requested();
  withheld_.setZero();
  delivered_before_ = limiter_.delivered();
}

void HapticLoop::keep(Instant<PhysicsClock> now, const RequestedForce& requested, ForceFault before,
                      double gain_before) {
  const ForceFault fault = guard_.fault();
  statistics_.peak_n = std::max(statistics_.peak_n, clamp_.last().norm());
  ++statistics_.ticks;
  statistics_.limited_ticks += limiter_.limited() || clamp_.tripped();
  statistics_.peak_limited_ticks += limiter_.limited() && limiter_.at_peak();
  statistics_.fault_ticks += fault != ForceFault::none && clamp_.last() == Vector3::Zero();
  statistics_.damped_ticks += passivity_.injected() > 0.0;
  statistics_.warm_ticks += heat_.warm();
  records_->push({now, joints_, tip_.X_world_tip.translation, requested.continuous + requested.impact,
                  clamp_.last(), fault, guard_.state(), tip_.velocity.norm(), guard_.strength().outage_s()});

  const bool became_safe = guard_.state() == ForceState::safe && told_.state != ForceState::safe;
  // A released button is a wish.
  const bool forces_taken = fault != ForceFault::none && fault != ForceFault::button_released &&
                            before == ForceFault::none && gain_before > 0.0;
  told_.state = guard_.state();
  told_.fault = fault;
  told_.culprit = culprit();
  told_.ticks = statistics_.ticks;
  if (became_safe || forces_taken) {
    ++told_.trips;
    told_.trip_tick = statistics_.ticks;
    told_.trip_fault = fault;
    told_.trip_culprit = told_.culprit;
    trips_->push({statistics_.ticks, now, fault, told_.culprit});
  }
  condition_.write(told_);
}

void HapticLoop::tell(HapticTick& told, const device::ArmSample& sample,
                      const RequestedForce& requested) const {
  told.number = statistics_.ticks;
  told.sample = sample;
  told.tip = tip_.X_world_tip.translation;
  told.speed = tip_.velocity.norm();
  told.continuous = requested.continuous;
  told.impact = requested.impact;
  told.commanded = clamp_.last();
  told.state = guard_.state();
  told.fault = guard_.fault();
  told.culprit = told_.culprit;
}

std::vector<HapticRecord> HapticLoop::records_before(std::uint64_t tick) const {
  const std::uint64_t end = std::min(tick, records_->count());
  const auto wanted = static_cast<std::uint64_t>(
      std::min(std::max(1.0, settings_.record_s / period_), static_cast<double>(HapticRecords::capacity())));
  std::vector<HapticRecord> list;
  list.reserve(std::min(wanted, end));
  for (std::uint64_t i = end - std::min(wanted, end); i < end; ++i)
    if (const auto record = records_->read(i)) list.push_back(*record);
  return list;
}

}  // namespace palpate::haptics
