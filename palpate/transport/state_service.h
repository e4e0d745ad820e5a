// The physics server's end of the exchange: answers graphics servers from the state history, beside the
// loops.
//
// The answering happens in the engine (a network thread of its own with ZeroMQ); the physics loop calls
// nothing but take_control(), which neither locks nor allocates. A destroyed service stops answering at once.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "palpate/scene/application.h"
#include "palpate/scene/scene_state.h"

namespace palpate::transport {

// Looks a state up for a time; called on several network threads, must not wait and must not throw.
using StateSource = std::function<scene::StateAnswer(Instant<PhysicsClock>)>;

// Fills the numbers of the scene's deforming surface for a time, and says for which time it could; nothing
// while there is no shape. Called on the network thread, must not wait and must not throw.
using ShapeSource =
    std::function<std::optional<Instant<PhysicsClock>>(Instant<PhysicsClock>, std::span<float>)>;

struct ServiceCounters {
  int clients = 0;                         // heard of within the last second
  std::uint64_t requests = 0;              // states answered
  std::uint64_t syncs = 0;                 // clock exchanges answered
  std::uint64_t controls = 0;              // wishes handed over
  std::uint64_t rejected = 0;              // messages that failed the check, and subscriptions refused
  std::uint64_t rejected_connections = 0;  // attempts with keys that are not admitted
  std::uint64_t unsent = 0;  // answers and states that could not leave: the client does not take them
};

class StateService {
 public:
  virtual ~StateService() = default;
  // The next wish of a person at a graphics server. One thread, the physics loop.
  virtual std::optional<scene::Control> take_control() = 0;
  // Any thread.
  virtual ServiceCounters counters() const = 0;
  // Where it listens, as a client would name it.
  virtual std::string endpoint() const = 0;
  // Where observers subscribe to states; empty where they cannot.
  virtual std::string states_endpoint() const { return {}; }
};

}  // namespace palpate::transport
