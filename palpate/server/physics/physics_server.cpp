#include "palpate/server/physics/physics_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "palpate/server/physics/internal/extrapolated_tip.h"

namespace palpate::server::physics {
namespace {

const rig::ArmCalibration& arm_of(const rig::Rig& rig) {
  if (!rig.arm)
    throw std::invalid_argument(
        "physics server: the rig has no arm calibration; run `palpate calibrate arm`");
  return *rig.arm;
}

}  // namespace

PhysicsServer::PhysicsServer(const rig::Rig& rig, const scene::SceneDescription& scene,
                             std::unique_ptr<scene::Application> application, device::ArmDevice& arm,
                             const haptics::HapticSettings& settings, const ThreadClock* clock)
    : application_(std::move(application)),
      application_name_(scene.application),
      application_words_(haptics::name_of(haptics::Guest::application, scene.application)),
      haptic_(arm, arm_of(rig), rig.nominal_arm, settings, to_haptic_, to_physics_,
              {scene.application, application_->contact_law(), clock}),
      history_(scene.gravity),
      shapes_(application_->shape().size() / scene::Shape::kFloatsPerVertex),
      calm_speed_(0.5 * settings.limits.max_tip_speed_m_s) {}

void PhysicsServer::haptic_tick(Instant<PhysicsClock> now, haptics::HapticTick* told) {
  if (ticks_ == nullptr) {
    haptic_.tick(now, told);
    judge_calm(now);
    return;
  }
  haptics::HapticTick written;
  haptic_trace_.write();
  const InputTrace::Scope scope(&haptic_trace_);
  haptic_.tick(now, &written);
  judge_calm(now);
  ticks_->haptic.push(written, haptic_trace_);
  if (told != nullptr) *told = written;
}

void PhysicsServer::judge_calm(Instant<PhysicsClock> now) {
  constexpr Duration kCalm = std::chrono::milliseconds(500);
  const bool calm =
      haptic_.fault() == device::ForceFault::overspeed && haptic_.tip().velocity.norm() < calm_speed_;
  if (!calm) restless_ = now;
  const bool asked = InputTrace::pass(rearm_asked_.exchange(false, std::memory_order_relaxed)) != 0;
  if (now - restless_ >= kCalm || asked) haptic_.rearm();
}

void PhysicsServer::fail(const char* what) noexcept {
  if (failed()) return;
  std::strncpy(failure_.data(), what, failure_.size() - 1);
  failed_.store(true, std::memory_order_release);
}

std::string PhysicsServer::trouble() const {
  if (!failed()) return {};
  return fmt::format(
      "{} threw: {}; it is not called again and forces stay off until the server is started anew",
      application_words_, failure_.data());
}

std::string PhysicsServer::culprit() const {
  const haptics::Guest guest = haptic_.condition().culprit;
  const bool ours = failed() || guest == haptics::Guest::application || guest == haptics::Guest::contact_law;
  constexpr std::size_t kMost = 64;  // of a status
  return ours ? application_name_.substr(0, kMost) : std::string();
}

void PhysicsServer::delay_forces(Duration delay) {
  if (delay < Duration(0) || delay > decltype(delay_line_)::kMost)
    throw std::invalid_argument("physics server: the extra force delay must lie in 0 ... 200 ms");
  delay_line_.set(delay);
  haptic_.delay_law(delay);
}

// That of the step to come: wishes before it are part of it. Where nobody records, whatever trace is in hand.
InputTrace* PhysicsServer::trace_of_step() {
  if (ticks_ == nullptr) return InputTrace::current();
  if (!step_traced_) step_trace_.write();
  step_traced_ = true;
  return &step_trace_;
}

void PhysicsServer::physics_tick(Instant<PhysicsClock> now) {
  {
    const InputTrace::Scope scope(trace_of_step());
    const bool moved = move_on(now);
    if (ticks_ != nullptr) ticks_->steps.push(now, moved ? &state_ : nullptr, step_trace_);
  }
  step_traced_ = false;
  steps_ended_.fetch_add(1, std::memory_order_relaxed);
}

// Whether the world has moved.
bool PhysicsServer::move_on(Instant<PhysicsClock> now) {
  tip_known_ = to_physics_.read(tip_) || tip_known_;
  if (!tip_known_) return false;  // no arm yet: nothing moves in the world before its first reading
  const Duration dt = last_ ? now - *last_ : Duration(1'000'000);
  if (dt <= Duration(0)) return false;
  last_ = now;
  state_.time = now;
  ++state_.tick;
  std::span<const float> shape;
  run_application([&] {
    application_->step(now, dt, extrapolated_to(tip_, now), state_);
    shape = application_->shape();
    felt_ = haptics::haptic_input(state_, application_->impact(), felt_);
  });
  if (failed()) return false;
  if (shows_the_tip(now)) history_.push(state_);
  if (shapes_.vertices() > 0 && now >= next_shape_) {
    shapes_.push(now, shape);
    const Duration period = seconds(1.0 / scene::ShapeHistory::kRateHz);
    next_shape_ =
        std::max(next_shape_ + period, now - period);  // the rate on average; no pause is made up for
  }
  if (const auto input = delay_line_.push(felt_, now))
    to_haptic_.write(haptics::later(*input, delay_line_.delay()));
  return true;
}

// In a gap between two readings the tip stands still in the states, wherever the hand has gone; a hand at 1.5 m/s goes 15 mm in
// ten milliseconds. What was left out of the history is bridged by both sides' places and velocities. An arm that is silent for longer
// is shown where it was last.
bool PhysicsServer::shows_the_tip(Instant<PhysicsClock> now) const {
  constexpr Duration kLongestBridge = std::chrono::milliseconds(50);
  const Duration age = now - tip_.time;
  return age <= kLongestCarry || age > kLongestBridge;
}

scene::SceneDescription scene_from_rig(const rig::Rig& rig, scene::SceneDescription described) {
  described.surfaces.clear();
  for (const auto& surface : rig.surfaces) {
    scene::SceneSurface s;
    s.name = surface.name;
    for (int i = 0; i < 4; ++i) s.corners[static_cast<std::size_t>(i)] = surface.corner(i).m;
    described.surfaces.push_back(s);
  }
  described.arm_tips.clear();
  if (rig.arm)
    for (const auto& tip : rig::tips_of_arm(*rig.arm)) described.arm_tips.push_back(tip.m);
  return described;
}

}  // namespace palpate::server::physics
