#include "palpate/server/session/same_places.h"

#include "palpate/core/log.h"
#include "palpate/scene/scene_comparison.h"
#include "palpate/server/physics/physics_server.h"

namespace palpate::server::session {

Expected<void> same_places(const rig::Rig& rig, const scene::SceneDescription& scene,
                           const std::string& address) {
  const auto ours = physics::scene_from_rig(rig, {}).surfaces;
  const auto compared = scene::compare_surfaces(ours, scene.surfaces);
  if (compared.agree()) return {};
  if (compared.elsewhere())
    return refused(
        "graphics: the physics server at {} has another rig: {}; forces and pictures would be in different "
        "places, both servers need the same rig file",
        address, compared.words());
  Log("graphics")
      .warning("the physics server at {} has another rig: {}; both servers need the same rig file", address,
               compared.words());
  return {};
}

}  // namespace palpate::server::session
