#include "applications/registry.h"

#include "applications/applications.h"
#include "applications/pingpong/record.h"
#include "applications/touch/record.h"

namespace palpate::applications {
namespace {

// Hands on what was made, or throws what was refused, as a guest does.
template <typename Made>
Made made(Expected<Made> part) {
  if (!part) throw std::invalid_argument(part.error().message);
  return std::move(*part);
}

scene::ApplicationSpec spec_of(const ApplicationInfo& info) {
  scene::ApplicationSpec spec;
  spec.name = info.name;
  spec.summary = info.summary;
  spec.surfaces = {"table"};
  if (info.name == "pingpong") spec.surfaces.emplace_back("wall");
  spec.make_physics = [](const scene::SceneDescription& scene, const scene::RunSettings& run) {
    return made(make_application(scene, run.seed, run.pause_s));
  };
  spec.make_view = [](const scene::SceneDescription& scene) { return made(make_scene_view(scene)); };
  spec.make_player = [](const scene::SceneDescription& scene, const scene::Reach& reach,
                        const scene::PlayerSettings& settings) {
    return made(make_player(scene, reach, settings));
  };
  return spec;
}

}  // namespace

const scene::ApplicationRegistry& registry() {
  static const scene::ApplicationRegistry all = [] {
    scene::ApplicationRegistry registry;
    for (const auto& info : applications()) {
      auto spec = spec_of(info);
      info.name == "pingpong" ? pingpong::add_record(spec) : touch::add_record(spec);
      registry.add(std::move(spec));
    }
    return registry;
  }();
  return all;
}

}  // namespace palpate::applications
