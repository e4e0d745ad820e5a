// For tests: the smallest rig that physics runs, an uncalibrated arm over a table and a wall of one metre each.
#pragma once

#include <numbers>

#include "palpate/math/so3.h"
#include "palpate/rig/rig.h"

namespace palpate::server::physics {

inline rig::Rig rig_of_table_and_wall() {
  rig::Rig made;
  made.arm.emplace();
  rig::SurfaceCalibration table, wall;
  table.name = "table";
  table.width = table.height = 1.0;
  table.X_world_rectangle.rotation = rotation_from_xyz({-std::numbers::pi / 2.0, 0.0, 0.0});  // faces up
  wall.name = "wall";
  wall.width = wall.height = 1.0;
  made.surfaces = {table, wall};
  return made;
}

}  // namespace palpate::server::physics
