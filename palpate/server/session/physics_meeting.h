// A graphics server's first meeting with a physics server: who is there, what is played, and is it the same place?
#pragma once

#include <atomic>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/time/real_time.h"
#include "palpate/transport/state_link.h"

namespace palpate::server::session {

// A physics server prepares what it plays before it answers, an organ for half a minute.
inline constexpr double kPatienceForPhysicsS = 60.0;

struct Awaited {
  const char* by;       // who waits, as its messages name it
  std::string address;  // of the physics server
  double patience_s = kPatienceForPhysicsS;
};

// Waits until the physics server has said what it plays; refused, in words, where it does not within the patience, turns
// away for ten seconds, or `stop` becomes true.
Expected<scene::SceneDescription> await_scene(transport::StateLink& link, const Awaited& awaited,
                                              const MonotonicClock<GraphicsClock>& clock,
                                              const std::atomic<bool>& stop);

// Refused where a surface lies so far from where `rig` has it that forces and pictures would be in different places
// (RigComparison::elsewhere()). What differs less is a condition while it lasts (GraphicsServer::set_drawn).
Expected<void> same_places(const rig::Rig& rig, const scene::SceneDescription& scene,
                           const std::string& address);

}  // namespace palpate::server::session
