// The exchange over ZeroMQ: the physics server's ROUTER with a network thread of its own, the graphics
// server's DEALER with a thread that stamps arrivals. No exception crosses this interface.
//
// Neither side waits for the other: queues are bounded, nothing lingers, a dead peer is dropped after 0.4 s
// without a sign of life and sought again every 50 ms. Addresses come checked from local_endpoint.h. Create
// both from an ordinary thread: their threads inherit its scheduling class and must not be real-time.
#pragma once

#include <memory>
#include <string>

#include "palpate/time/clock.h"
#include "palpate/transport/keys.h"
#include "palpate/transport/local_endpoint.h"
#include "palpate/transport/state_link.h"
#include "palpate/transport/state_service.h"

namespace palpate::transport {

struct ServiceOptions {
  std::optional<ServerIdentity> identity;  // for an encrypted endpoint
  StatusSource status;                     // for who asks how the server is doing
  ShapeSource shape;                       // of the scene's deforming surface, where it has one
};

// Starts answering at `endpoint`; refused where another server does so already, and where an encrypted
// endpoint comes without keys. Over an encrypted endpoint each client has the role of its key; at any other,
// whoever gets there is an operator. `source` is called on the network thread. `clock` must be safe from any
// thread and outlive the service.
Expected<std::unique_ptr<StateService>> serve_states(const Endpoint& endpoint,
                                                     const Clock<PhysicsClock>& clock, StateSource source,
                                                     scene::SceneDescription scene,
                                                     const ServiceOptions& options = {});

// A link to `endpoint`, whether anybody is there yet or not. `clock` must be safe from any thread and outlive
// it.
Expected<std::unique_ptr<StateLink>> connect_states(const Endpoint& endpoint,
                                                    const Clock<GraphicsClock>& clock,
                                                    std::string name = "graphics",
                                                    const std::optional<ClientIdentity>& identity = {});

}  // namespace palpate::transport
