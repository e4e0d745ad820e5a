// For tests: the exchange over a real unix socket in a folder of its own.
#pragma once

#include <thread>

#include "palpate/transport/exchange_rig_test.h"
#include "palpate/transport/zmq_engine.h"
#include "tests/scratch_folder.h"

namespace palpate::transport::testing {

class ZmqRig : public ExchangeRig {
 public:
  ZmqRig()
      : endpoint(
            *parse_endpoint("ipc://" + (scratch.path() / "physics.sock").string(), EndpointUse::listen)) {}
  explicit ZmqRig(Endpoint at) : endpoint(std::move(at)) {}

  Expected<std::unique_ptr<StateService>> serve(scene::SceneDescription scene = table_scene()) override {
    return serve_states(endpoint, physics_clock, state_at, std::move(scene),
                        {.identity = {}, .status = {}, .shape = shape_at});
  }
  std::unique_ptr<StateLink> connect(std::string name = "graphics") override {
    return std::move(*connect_states(endpoint, graphics_clock, std::move(name)));
  }
  void wait_a_little() override { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }

  ScratchFolder scratch;
  Endpoint endpoint;
  MonotonicClock<PhysicsClock> physics_clock{100.0, 0.0};
  MonotonicClock<GraphicsClock> graphics_clock{7.0, 0.0};
};

}  // namespace palpate::transport::testing
