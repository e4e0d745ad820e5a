#include "palpate/server/graphics/real_objects.h"

#include <fmt/format.h>

namespace palpate::server::graphics {

Expected<RealObjects> RealObjects::read(const rig::Rig& rig) {
  RealObjects real;
  for (const rig::RealObject& object : rig.objects) {
    auto file = scene::read_mesh(rig.folder / object.mesh, object.metres_per_unit);
    if (!file) return wrong_use("object '{}' of the rig: {}", object.name, file.error().message);
    real.meshes.push_back(std::move(file->mesh));
    real.objects.push_back(object);
  }
  return real;
}

std::vector<render::RealBody> RealObjects::bodies() const {
  std::vector<render::RealBody> all;
  for (std::size_t i = 0; i < objects.size(); ++i)
    all.push_back({&meshes[i], objects[i].rotation, objects[i].position});
  return all;
}

render::CompositorSettings picture_settings(const rig::Rig& rig, render::Quality quality) {
  render::CompositorSettings settings = render::settings_of(quality);
  if (rig.light) settings.light = *rig.light;
  if (rig.camera) settings.encoding = rig.camera->encoding;
  return settings;
}

}  // namespace palpate::server::graphics
