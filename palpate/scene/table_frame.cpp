#include "palpate/scene/table_frame.h"

#include <algorithm>
#include <stdexcept>

namespace palpate::scene {

TableFrame table_frame(const SceneDescription& scene) {
  const auto table = std::ranges::find(scene.surfaces, "table", &SceneSurface::name);
  if (table == scene.surfaces.end())
    throw std::invalid_argument("the scene has no surface 'table'; run `palpate calibrate surface`");
  const auto& c = table->corners;
  const Vector3 right = (c[1] - c[0]).normalized();
  const Vector3 up = (c[1] - c[0]).cross(c[3] - c[0]).normalized();
  const Vector3 near = right.cross(up);
  Matrix3 R;
  R << right, up, near;
  return {0.5 * (c[0] + c[1]), right, up, near, Quaternion(R)};
}

}  // namespace palpate::scene
