#include "palpate/server/session/physics_meeting.h"

#include <algorithm>
#include <thread>

#include "palpate/core/log.h"
#include "palpate/core/text.h"
#include "palpate/scene/scene_comparison.h"
#include "palpate/server/physics/physics_server.h"

namespace palpate::server::session {
namespace {

// What is being waited for is told after so long.
constexpr double kToldAfterS = 3.0;
// A server that is there and lets nobody in will hardly think better of it.
constexpr double kTurnedAwayAfterS = 10.0;

}  // namespace

Expected<scene::SceneDescription> await_scene(transport::StateLink& link, const Awaited& awaited,
                                              const MonotonicClock<GraphicsClock>& clock,
                                              const std::atomic<bool>& stop) {
  const auto start = clock.now();
  bool told = awaited.patience_s <= kToldAfterS;
  while (!link.description()) {
    link.poll();
    if (stop.load()) return refused("{}: stopped before the physics server answered", awaited.by);
    const double waited = to_seconds(clock.now() - start);
    const auto trouble = link.trouble();
    if (waited > std::min(awaited.patience_s, kTurnedAwayAfterS)) {
      if (link.refusal())
        return refused("{}: the physics server at {} refuses: {}", awaited.by, awaited.address,
                       excerpt(*link.refusal(), 200));
      if (trouble)
        return refused("{}: the physics server at {} turns us away: {}", awaited.by, awaited.address,
                       *trouble);
    }
    if (waited > awaited.patience_s)
      return refused("{}: no physics server answers at {} after {:.0f} s; start `palpate physics` first",
                     awaited.by, awaited.address, awaited.patience_s);
    if (!told && waited > kToldAfterS && !link.refusal() && !trouble) {
      told = true;
      Log(awaited.by)
          .info("no physics server answers at {} yet; waiting for one, {:.0f} s at most", awaited.address,
                awaited.patience_s);
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
