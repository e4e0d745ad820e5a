// A whole session as a value: rig + devices by URI + application. Started it is a Session, in threads on the machine's
// clock; opened it is a TickedSession, on a virtual one.
//
//   SessionSetup setup;
//   setup.physics.rig = *rig::read_rig("rig.toml");
//   setup.physics.applications = {my_application()};
//   setup.physics.scene = *setup.physics.applications.describe("my-application", {});
//   drivers::openhaptics::add_to(setup.physics.drivers);
//   drivers::cameras::add_to(setup.physics.drivers);
//   setup.physics.arm.uri = "openhaptics";
//   setup.graphics.camera = device::CameraRequest{"v4l2", {}};
//   auto session = Session::start(setup, {});
#pragma once

#include "palpate/server/physics/physics_side.h"
#include "palpate/server/session/graphics_setup.h"

namespace palpate::server::session {

struct SessionSetup {
  physics::PhysicsSetup physics;
  GraphicsSetup graphics;  // rig, applications and drivers are those of `physics`, whatever stands here
  // Instead of what graphics.pixels says; must outlive the session.
  graphics::FramePipeline* pipeline = nullptr;
};

// The graphics side's set-up with what it has in common with the physics side.
inline GraphicsSetup graphics_setup(const SessionSetup& setup) {
  GraphicsSetup graphics = setup.graphics;
  graphics.rig = setup.physics.rig;
  graphics.applications = setup.physics.applications;
  graphics.drivers = setup.physics.drivers;
  return graphics;
}

}  // namespace palpate::server::session
