#include "palpate/server/session/ticked_session.h"

namespace palpate::server::session {

Expected<std::unique_ptr<TickedSession>> TickedSession::open(const SessionSetup& setup,
                                                             const VirtualTime& time) {
  std::unique_ptr<TickedSession> session(new TickedSession(time));
  auto physics = physics::PhysicsSide::open(setup.physics);
  if (!physics) return tl::unexpected(physics.error());
  session->physics_ = std::move(*physics);
  if (!session->physics_->arm().facts().simulated)
    return wrong_use(
        "session: the arm {} is no computed one; on a virtual clock, which may run ahead of the real one or "
        "stand still, nothing would limit how its force changes: use Session",
        setup.physics.arm.uri);
  if (auto served = session->physics_->serve(session->network_); !served)
    return tl::unexpected(served.error());
  const GraphicsSetup shared = graphics_setup(setup);
  auto devices = GraphicsDevices::open(shared);
  if (!devices) return tl::unexpected(devices.error());
  auto graphics = GraphicsSide::make(shared, std::move(*devices), session->network_.connect(),
                                     session->physics_->scene(), setup.pipeline);
  if (!graphics) return tl::unexpected(graphics.error());
  session->graphics_ = std::move(*graphics);
  return session;
}

void TickedSession::tick_physics(Instant<TrueTime> t) {
  network_.advance_to(t);
  physics_->haptic_tick(time_.physics(t));
  physics_->physics_tick(time_.physics(t));
}

const graphics::FrameRecord* TickedSession::tick_graphics(Instant<TrueTime> t) {
  const auto now = time_.graphics(t);
  graphics_->service(now);
  if (graphics_->begin(now)) finish_at_ = t + time_.drawing_time;
  const graphics::FrameRecord* frame = nullptr;
  if (finish_at_ && t >= *finish_at_) {
    finish_at_.reset();
    frame = &graphics_->finish(now);
    graphics_->server().shown(now);
  }
  graphics_->lead_hand(now);
  return frame;
}

}  // namespace palpate::server::session
