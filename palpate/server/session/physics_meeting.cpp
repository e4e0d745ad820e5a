#include "palpate/server/session/physics_meeting.h"

#include <thread>

#include "palpate/core/text.h"
#include "palpate/scene/scene_comparison.h"
#include "palpate/server/physics/physics_server.h"

namespace palpate::server::session {
namespace {

// How long a physics server may take to answer for the first time before the wait is given up.
constexpr double kPatienceS = 10.0;

}  // namespace

Expected<scene::SceneDescription> await_scene(transport::StateLink& link, const std::string& address,
                                              const MonotonicClock<GraphicsClock>& clock,
                                              const std::atomic<bool>& stop) {
  const auto start = clock.now();
  while (!link.description()) {
    link.poll();
    if (stop.load()) return refused("graphics: stopped before the physics server answered");
    if (to_seconds(clock.now() - start) > kPatienceS) {
      if (link.refusal())
        return refused("graphics: the physics server at {} refuses: {}", address,
                       excerpt(*link.refusal(), 200));
      if (const auto trouble = link.trouble())
        return refused("graphics: the physics server at {} turns us away: {}", address, *trouble);
      return refused(
          "graphics: no physics server answers at {} after {:.0f} s; start `palpate physics` first", address,
          kPatienceS);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return *link.description();
}

Expected<void> same_places(const rig::Rig& rig, const scene::SceneDescription& scene,
                           const std::string& address) {
  const auto compared = scene::compare_rigs(physics::scene_from_rig(rig, {}), scene);
  if (!compared.elsewhere()) return {};
  return refused(
      "graphics: the physics server at {} has another rig: {}; forces and pictures would be in different "
      "places, both servers need the same rig file",
      address, compared.words());
}

}  // namespace palpate::server::session
