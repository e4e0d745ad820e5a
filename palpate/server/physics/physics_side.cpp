#include "palpate/server/physics/physics_side.h"

#include <utility>

#include "palpate/haptics/arm_check.h"

namespace palpate::server::physics {
namespace {

haptics::HapticSettings haptic_settings(const PhysicsSetup& setup, const device::ArmFacts& arm) {
  haptics::HapticSettings settings;
  settings.period = seconds(1.0 / setup.haptic_hz);
  settings.limits = haptics::lowered_to(haptics::force_limits_of(setup.rig.arm->model), arm);
  settings.permit = haptics::ForcePermit::of(arm, setup.rig);
  settings.armed = setup.armed;
  return settings;
}

}  // namespace

Expected<std::unique_ptr<PhysicsSide>> PhysicsSide::open(const PhysicsSetup& setup,
                                                         const ThreadClock* guests) {
  if (!setup.rig.arm)
    return refused("physics: the rig has no arm calibration; run `palpate calibrate arm` on it");
  std::unique_ptr<PhysicsSide> side(new PhysicsSide);
  side->scene_ = setup.scene.surfaces.empty() ? scene_from_rig(setup.rig, setup.scene) : setup.scene;
  auto application = setup.applications.make_physics(side->scene_, setup.run);
  if (!application) return tl::unexpected(application.error());
  device::ArmRequest request = setup.arm;
  request.nominal = setup.rig.nominal_arm;
  if (!setup.drivers.names_arm(request.uri))
    return wrong_use("arm: {}", setup.drivers.check(request).error().message);
  auto arm = setup.drivers.open(request);
  if (!arm) return tl::unexpected(arm.error());
  if (auto fine = haptics::check_arm(setup.rig, **arm, request.uri); !fine)
    return tl::unexpected(fine.error());
  side->arm_ = std::move(*arm);
  side->server_.emplace(setup.rig, side->scene_, std::move(*application), side->arm_->device(),
                        haptic_settings(setup, side->arm_->facts()), guests);
  side->server_->delay_forces(setup.extra_force_delay);
  side->scene_.shape_vertices = side->server_->shape_vertices();
  return side;
}

Expected<void> PhysicsSide::serve(const transport::Endpoint& endpoint, const Clock<PhysicsClock>& clock,
                                  std::optional<transport::ServerIdentity> identity) {
  auto service = transport::serve_states(
      endpoint, clock, [this](Instant<PhysicsClock> t) { return server_->state_at(t); }, scene_,
      {.identity = std::move(identity),
       .status = [this] { return board_.read(); },
       .shape = [this](Instant<PhysicsClock> t, std::span<float> out) { return server_->shape_at(t, out); }});
  if (!service) return tl::unexpected(service.error());
  service_ = std::move(*service);
  return {};
}

Expected<void> PhysicsSide::serve(transport::InProcessNetwork& network) {
  auto service = network.serve(
      [this](Instant<PhysicsClock> t) { return server_->state_at(t); }, scene_,
      [this](Instant<PhysicsClock> t, std::span<float> out) { return server_->shape_at(t, out); });
  if (!service) return tl::unexpected(service.error());
  service_ = std::move(*service);
  return {};
}

void PhysicsSide::physics_tick(Instant<PhysicsClock> now) {
  if (service_)
    while (const auto control = service_->take_control()) server_->control(*control);
  server_->physics_tick(now);
}

}  // namespace palpate::server::physics
