// For tests: a physics server and graphics servers on either engine, behind one face.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "palpate/transport/in_process.h"

namespace palpate::transport::testing {

// A state that can be recognised: body 0 moves along x at 1 m/s and does not say so, body 1 speeds up by 3 m/s^2 and says its
// velocity; tick counts milliseconds.
inline scene::StateAnswer state_at(Instant<PhysicsClock> time) {
  scene::StateAnswer answer;
  answer.kind = AnswerKind::interpolated;
  answer.state.time = time;
  answer.state.tick = static_cast<std::uint64_t>(std::max<std::int64_t>(time.ns(), 0) / 1'000'000);
  answer.state.body_count = 2;
  answer.state.bodies[0].position = {time.seconds(), 0.25, -0.5};
  answer.state.bodies[1].position = {1.5 * time.seconds() * time.seconds(), 0.0, 0.0};
  answer.state.bodies[1].velocity = {3.0 * time.seconds(), 0.0, 0.0};
  answer.state.bodies[1].jumps = 7;
  answer.state.counters[3] = -4;
  answer.state.continuous.force = {0.0, 1.5, 0.0};
  return answer;
}

inline scene::SceneDescription table_scene(const std::string& application = "marbles") {
  scene::SceneDescription scene;
  scene.application = application;
  scene.surfaces.push_back(
      {"table", {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 0, 1), Vector3(0, 0, 1)}});
  return scene;
}

// A surface that can be recognised: number i is the time in seconds plus i thousandths.
inline std::optional<Instant<PhysicsClock>> shape_at(Instant<PhysicsClock> time, std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = static_cast<float>(time.seconds() + 1e-3 * static_cast<double>(i));
  return time;
}
inline scene::SceneDescription cloth_scene(std::size_t vertices = 10'000) {
  scene::SceneDescription scene = table_scene("cloth");
  scene.shape_vertices = vertices;
  return scene;
}

class ExchangeRig {
 public:
  virtual ~ExchangeRig() = default;
  virtual Expected<std::unique_ptr<StateService>> serve(scene::SceneDescription scene = table_scene()) = 0;
  virtual std::unique_ptr<StateLink> connect(std::string name = "graphics") = 0;
  // Lets a millisecond pass.
  virtual void wait_a_little() = 0;

  // Polls the links each millisecond until `done` or `limit`; the limit only ends a test that has failed.
  bool until(const std::vector<StateLink*>& links, const std::function<bool()>& done,
             Duration limit = std::chrono::seconds(10)) {
    for (Duration waited{0}; waited < limit; waited += std::chrono::milliseconds(1)) {
      for (StateLink* link : links) link->poll();
      if (done()) return true;
      wait_a_little();
    }
    return false;
  }
};

class InProcessRig : public ExchangeRig {
 public:
  explicit InProcessRig(ChannelModel model = {}, std::uint64_t seed = 1)
      : network(
            model, seed,
            [](Instant<TrueTime> t) { return Instant<PhysicsClock>{t.since_epoch + seconds(100.0)}; },
            [](Instant<TrueTime> t) { return Instant<GraphicsClock>{t.since_epoch + seconds(7.0)}; }) {}
  Expected<std::unique_ptr<StateService>> serve(scene::SceneDescription scene = table_scene()) override {
    return network.serve(state_at, std::move(scene), shape_at, [this] { return status; });
  }
  std::unique_ptr<StateLink> connect(std::string name = "graphics") override {
    return network.connect(std::move(name));
  }
  void wait_a_little() override { network.advance_to(network.now() + std::chrono::milliseconds(1)); }

  InProcessNetwork network;
  ServerStatus status;  // what the physics server says of itself
};

}  // namespace palpate::transport::testing
