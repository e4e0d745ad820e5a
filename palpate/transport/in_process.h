// The exchange without a wire: servers and links in one process on virtual time, with delay, loss,
// duplication and reordering drawn from a seed. Deterministic to the bit; messages go through the same bytes
// as on the real wire.
//
// One thread. Nothing happens but in advance_to(): it carries every message due until then, in order of time,
// and stamps it with the clocks read at that very moment. Advance the network to t before the physics loop
// steps to t, so that no answer knows a state of its future. Links and services may outlive the network
// object.
#pragma once

#include <functional>
#include <memory>

#include "palpate/transport/state_link.h"
#include "palpate/transport/state_service.h"

namespace palpate::transport {

struct ChannelModel {
  // One way. Defaults: half of a paced round trip over a unix socket on a small virtual machine (0.3 ms).
  Duration delay = std::chrono::microseconds(150);
  Duration jitter = std::chrono::microseconds(50);  // mean of an exponential distribution on top
  double loss = 0.0;                                // probability that a message vanishes
  double duplication = 0.0;                         // probability that it comes a second time
  double reordering =
      0.0;  // probability that it is held back by held_back and overtaken; otherwise order is kept
  Duration held_back = std::chrono::milliseconds(40);
};

class InProcessNetwork {
 public:
  // The two hosts' clocks as functions of true time.
  using PhysicsTime = std::function<Instant<PhysicsClock>(Instant<TrueTime>)>;
  using GraphicsTime = std::function<Instant<GraphicsClock>(Instant<TrueTime>)>;

  InProcessNetwork(ChannelModel model, std::uint64_t seed, PhysicsTime physics_time,
                   GraphicsTime graphics_time);

  // Starts a physics server; refused while another one lives, as an address in use.
  Expected<std::unique_ptr<StateService>> serve(StateSource source, scene::SceneDescription scene,
                                                ShapeSource shape = {}, StatusSource status = {});
  // A new graphics server's link; the physics server need not be there.
  std::unique_ptr<StateLink> connect(std::string name = "graphics", Role role = Role::operator_);

  void advance_to(Instant<TrueTime> now);
  Instant<TrueTime> now() const;

  // The model may change while running: messages sent from now on follow the new one.
  void set_model(const ChannelModel& model);

 private:
  struct Net;
  class Wire;
  class Service;
  std::shared_ptr<Net> net_;
};

}  // namespace palpate::transport
