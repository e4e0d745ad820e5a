#include "palpate/system/real_objects.h"

#include <fmt/format.h>

namespace palpate {

Expected<RealObjects> RealObjects::read(const Rig& rig) {
  RealObjects real;
  for (const RealObject& object : rig.objects) {
    auto file = read_mesh(rig.folder / object.mesh, object.metres_per_unit);
    if (!file) return wrong_use("object '{}' of the rig: {}", object.name, file.error().message);
    real.meshes.push_back(std::move(file->mesh));
    real.objects.push_back(object);
  }
  return real;
}

std::vector<RealBody> RealObjects::bodies() const {
  std::vector<RealBody> all;
  for (std::size_t i = 0; i < objects.size(); ++i)
    all.push_back({&meshes[i], objects[i].rotation, objects[i].position});
  return all;
}

CompositorSettings picture_settings(const Rig& rig, Quality quality) {
  CompositorSettings settings = settings_of(quality);
  if (rig.light) settings.light = *rig.light;
  if (rig.camera) settings.encoding = rig.camera->encoding;
  return settings;
}

}  // namespace palpate
