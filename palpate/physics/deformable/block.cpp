#include "palpate/physics/deformable/block.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/physics/deformable/box_mesh.h"

namespace palpate::physics::deformable {
namespace {

constexpr double kGrowth = 1.45;  // at most, of a shell over the one within

int shells(const Vector3& size, double core, double element) {
  const double reach = std::max({0.5 * size.x() - core, 0.5 * size.y() - core, size.z() - core});
  int count = 0;
  for (double total = 0.0, part = element; total < reach && count < 40; part *= kGrowth, ++count)
    total += part;
  return std::max(3, count);
}

BoxMeshSettings settings_of(const Indentation& it, double widest) {
  BoxMeshSettings settings;
  settings.size = it.size;
  settings.half_x = settings.half_y = true;
  for (const auto& inclusion : it.material.inclusions) {
    settings.half_x = settings.half_x && inclusion.centre.x() == 0.0;
    settings.half_y = settings.half_y && inclusion.centre.y() == 0.0;
  }
  const double element = widest / it.fineness;
  settings.core = std::min(1.2 * widest, 0.3 * std::min(it.size.x(), it.size.y()));
  settings.core_depth = std::min(settings.core, 0.5 * it.size.z());
  settings.cells = std::max(2, static_cast<int>(std::ceil(settings.core / element - 1e-9)));
  settings.cells_down = std::max(2, static_cast<int>(std::ceil(settings.core_depth / element - 1e-9)));
  settings.shells = shells(it.size, settings.core, element);
  return settings;
}

}  // namespace

Expected<Block> mesh_block(const Indentation& it, double widest) {
  const auto settings = settings_of(it, widest);
  auto mesh = box_mesh(settings);
  if (!mesh) return tl::unexpected(mesh.error());
  FreeMotion motion(*mesh);
  for (const int node : nodes_on_plane(*mesh, 2, -it.size.z())) motion.hold(node);
  if (settings.half_x)
    for (const int node : nodes_on_plane(*mesh, 0, 0.0)) motion.hold(node, 0);
  if (settings.half_y)
    for (const int node : nodes_on_plane(*mesh, 1, 0.0)) motion.hold(node, 1);
  motion.number();
  return Block{std::move(*mesh), std::move(motion),
               (settings.half_x ? 2.0 : 1.0) * (settings.half_y ? 2.0 : 1.0)};
}

}  // namespace palpate::physics::deformable
