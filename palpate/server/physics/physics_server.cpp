#include "palpate/server/physics/physics_server.h"

#include <algorithm>
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
                             const haptics::HapticSettings& settings)
    : application_(std::move(application)),
      haptic_(arm, arm_of(rig), rig.nominal_lengths, settings, to_haptic_, to_physics_),
      history_(scene.gravity),
      shapes_(application_->shape().size() / scene::Shape::kFloatsPerVertex),
      calm_speed_(0.5 * settings.limits.max_tip_speed_m_s) {}

void PhysicsServer::haptic_tick(Instant<PhysicsClock> now) {
  haptic_.tick(now);
  constexpr Duration kCalm = std::chrono::milliseconds(500);
  const bool calm =
      haptic_.fault() == haptics::ForceFault::overspeed && haptic_.tip().velocity.norm() < calm_speed_;
  if (!calm) restless_ = now;
  if (now - restless_ >= kCalm || rearm_asked_.exchange(false, std::memory_order_relaxed)) haptic_.rearm();
}

void PhysicsServer::delay_forces(Duration delay) {
  if (delay < Duration(0) || delay > DelayLine::kMost)
    throw std::invalid_argument("physics server: the extra force delay must lie in 0 ... 200 ms");
  delay_line_.set(delay);
}

void PhysicsServer::physics_tick(Instant<PhysicsClock> now) {
  to_physics_.read(tip_);
  if (tip_.time.ns() == 0) return;  // no arm yet: nothing moves in the world before its first reading
  const Duration dt = last_ ? now - *last_ : Duration(1'000'000);
  if (dt <= Duration(0)) return;
  last_ = now;
  state_.time = now;
  ++state_.tick;
  application_->step(now, dt, extrapolated_to(tip_, now), state_);
  history_.push(state_);
  if (shapes_.vertices() > 0 && now >= next_shape_) {
    shapes_.push(now, application_->shape());
    const Duration period = seconds(1.0 / scene::ShapeHistory::kRateHz);
    next_shape_ =
        std::max(next_shape_ + period, now - period);  // the rate on average; no pause is made up for
  }
  felt_ = haptics::haptic_input(state_, application_->impact(), felt_);
  if (const auto input = delay_line_.push(felt_, now)) to_haptic_.write(*input);
}

scene::SceneDescription scene_from_rig(const rig::Rig& rig, scene::SceneDescription settings,
                                       double restitution) {
  settings.surfaces.clear();
  for (const auto& surface : rig.surfaces) {
    scene::SceneSurface s;
    s.name = surface.name;
    s.restitution = restitution;
    for (int i = 0; i < 4; ++i) s.corners[static_cast<std::size_t>(i)] = surface.corner(i).m;
    settings.surfaces.push_back(s);
  }
  return settings;
}

}  // namespace palpate::server::physics
