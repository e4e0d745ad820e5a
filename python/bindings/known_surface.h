// A surface that is calibrated already, on its way through Python to the landmarks on it: to the last bit.
#pragma once

#include <tuple>
#include <utility>

#include "palpate/rig/rig.h"
#include "python/bindings/conversions.h"

namespace palpate::python {

// Name, place (1 x 3) and quaternion (1 x 4), width, height, and by how much a hand missed it (m, freedoms).
using KnownSurface = std::tuple<std::string, Doubles, Doubles, double, double, std::pair<double, double>>;

inline KnownSurface known_surface(const rig::SurfaceCalibration& surface) {
  const auto& pose = surface.X_world_rectangle;
  return {surface.name,
          rows_of({pose.translation}),
          quaternion_rows({pose.rotation}),
          surface.width,
          surface.height,
          {surface.touch.sd, surface.touch.freedoms}};
}

inline rig::SurfaceCalibration surface_of(const KnownSurface& known) {
  rig::SurfaceCalibration surface;
  surface.name = std::get<0>(known);
  surface.X_world_rectangle = {quaternions_of(std::get<2>(known))[0], points_of(std::get<1>(known))[0]};
  surface.width = std::get<3>(known);
  surface.height = std::get<4>(known);
  surface.touch = {std::get<5>(known).first, std::get<5>(known).second};
  return surface;
}

}  // namespace palpate::python
