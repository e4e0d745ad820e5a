// A session that its owner ticks, on a virtual clock: both sides in one process and one thread, with the in-process
// network between them. Deterministic to the bit where its devices are.
//
//   for (auto t = begin + ms; t < end; t += ms) {
//     laboratory.advance_to(t);                       // whatever stands behind the devices
//     session->tick_physics(t);
//     if (const auto* frame = session->tick_graphics(t)) look(*frame);
//   }
//
// Errors: at opening what PhysicsSide and GraphicsSide refuse or throw; from then on nothing fails.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "palpate/core/expected.h"
#include "palpate/server/session/graphics_side.h"
#include "palpate/server/session/session_setup.h"
#include "palpate/transport/in_process.h"

namespace palpate::server::session {

// How time goes by in a ticked session.
struct VirtualTime {
  Instant<TrueTime> begin;
  // What the two hosts' clocks read; true time where nothing is said.
  transport::InProcessNetwork::PhysicsTime physics = [](Instant<TrueTime> t) {
    return Instant<PhysicsClock>{t.since_epoch};
  };
  transport::InProcessNetwork::GraphicsTime graphics = [](Instant<TrueTime> t) {
    return Instant<GraphicsClock>{t.since_epoch};
  };
  transport::ChannelModel channel;
  std::uint64_t seed = 1;                                 // of the channel's delays
  Duration drawing_time = std::chrono::milliseconds(12);  // from an image's arrival to its picture
};

class TickedSession {
 public:
  static Expected<std::unique_ptr<TickedSession>> open(const SessionSetup& setup, const VirtualTime& time);
  TickedSession(const TickedSession&) = delete;
  TickedSession& operator=(const TickedSession&) = delete;

  // To be called in this order for moments that grow, a millisecond apart or less.
  // Messages due until `t` arrive; then the haptic loop and the physics loop tick once each.
  void tick_physics(Instant<TrueTime> t);
  // Takes what has come, begins a frame, and returns the one that is finished now, if any (valid until the next one);
  // then the player leads the hand.
  const graphics::FrameRecord* tick_graphics(Instant<TrueTime> t);

  physics::PhysicsSide& physics() { return *physics_; }
  GraphicsSide& graphics() { return *graphics_; }

 private:
  TickedSession(const VirtualTime& time)
      : time_(time), network_(time.channel, time.seed, time.physics, time.graphics) {
    network_.advance_to(time.begin);
  }

  VirtualTime time_;
  transport::InProcessNetwork network_;
  std::unique_ptr<physics::PhysicsSide> physics_;
  std::unique_ptr<GraphicsSide> graphics_;
  std::optional<Instant<TrueTime>> finish_at_;
};

}  // namespace palpate::server::session
