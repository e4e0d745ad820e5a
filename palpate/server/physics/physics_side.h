// The physics side of a session, put together once for every way of running: the application from the registry, the
// scene from the rig, the arm by its URI, the limits of its model lowered to what the device states, the server, and
// what graphics servers are answered with.
//
// It knows no clock and no thread: PhysicsLoops ticks it on the machine's, others on a virtual one. Threads as of
// PhysicsServer: haptic_tick() in one, physics_tick() in one, or both in the same; the rest from the thread that
// opened it.
#pragma once

#include <memory>
#include <optional>

#include "palpate/core/expected.h"
#include "palpate/device/driver_registry.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application_registry.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/transport/in_process.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::server::physics {

// What a physics side is made of.
struct PhysicsSetup {
  rig::Rig rig;
  scene::ApplicationRegistry applications;
  scene::SceneDescription scene;  // where it has no surfaces, those of the rig are taken
  device::DriverRegistry drivers;
  device::ArmRequest arm{.uri = "lab", .nominal = {}};  // its model is taken from the rig
  scene::RunSettings run;
  double physics_hz = 1000.0, haptic_hz = 1000.0;
  bool armed = true;              // false: forces stay off until a person's `reset`
  Duration extra_force_delay{0};  // forces come so much later, on purpose
};

class PhysicsSide {
 public:
  // The application first, then the arm: who has asked for what is not there hears of it before anything moves.
  // Refused where the rig has no arm calibration, or a part cannot be had; throws as PhysicsServer. `guests`
  // measures what guests take in the haptic tick and must outlive the side; null where no time passes there.
  static Expected<std::unique_ptr<PhysicsSide>> open(const PhysicsSetup& setup,
                                                     const ThreadClock* guests = nullptr);
  PhysicsSide(const PhysicsSide&) = delete;
  PhysicsSide& operator=(const PhysicsSide&) = delete;

  // Answers graphics servers from now on; one of the two, once, before the first tick. The clock must be safe from
  // any thread and outlive the side.
  Expected<void> serve(const transport::Endpoint& endpoint, const Clock<PhysicsClock>& clock,
                       std::optional<transport::ServerIdentity> identity = {});
  Expected<void> serve(transport::InProcessNetwork& network);

  void haptic_tick(Instant<PhysicsClock> now) { server_->haptic_tick(now); }
  // Does first what people at graphics servers wish.
  void physics_tick(Instant<PhysicsClock> now);

  PhysicsServer& server() { return *server_; }
  const PhysicsServer& server() const { return *server_; }
  device::OpenedArm& arm() { return *arm_; }
  const scene::SceneDescription& scene() const { return scene_; }  // as it is served
  const transport::StateService& service() const { return *service_; }
  // What whoever asks for the status is told.
  transport::StatusBoard& board() { return board_; }

 private:
  PhysicsSide() = default;

  scene::SceneDescription scene_;
  std::unique_ptr<device::OpenedArm> arm_;
  std::optional<PhysicsServer> server_;
  transport::StatusBoard board_;
  std::unique_ptr<transport::StateService> service_;  // gone first: it looks states up
};

}  // namespace palpate::server::physics
