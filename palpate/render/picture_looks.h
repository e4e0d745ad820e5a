// How the compositor's materials look. Values.
#pragma once

#include "palpate/render/gl_objects.h"
#include "palpate/scene/application.h"

namespace palpate::render {

// Colour in linear light; mirror straight on, at the edge, the lamp's image.
struct Look {
  Vector3f albedo, surface;
};
inline Look look(scene::Material material) {
  switch (material) {
    case scene::Material::ball:
      return {{0.86f, 0.30f, 0.035f}, {0.010f, 0.10f, 0.10f}};
    case scene::Material::bat_front:
      return {{0.42f, 0.020f, 0.018f}, {0.015f, 0.12f, 0.06f}};
    case scene::Material::bat_back:
      return {{0.022f, 0.022f, 0.024f}, {0.020f, 0.14f, 0.06f}};
    case scene::Material::handle:
      return {{0.48f, 0.28f, 0.12f}, {0.020f, 0.10f, 0.10f}};
    case scene::Material::highlight:
      return {{0.16f, 0.62f, 0.22f}, {0.030f, 0.20f, 0.20f}};
    case scene::Material::figure:
      return {{0.52f, 0.42f, 0.34f}, {0.010f, 0.06f, 0.02f}};
    case scene::Material::camera:
      return {{0.045f, 0.050f, 0.060f}, {0.030f, 0.20f, 0.30f}};
    case scene::Material::sight:
      return {{0.85f, 0.72f, 0.04f}, {0.0f, 0.0f, 0.0f}};
    case scene::Material::floor:
      return {{0.33f, 0.27f, 0.21f}, {0.0f, 0.0f, 0.0f}};
    case scene::Material::floor_shade:
      return {{0.21f, 0.17f, 0.135f}, {0.0f, 0.0f, 0.0f}};
    case scene::Material::furniture:
      return {{0.10f, 0.10f, 0.105f}, {0.01f, 0.05f, 0.05f}};
  }
  return {};
}
// Real things in a view from outside.
inline const Look kLevelLook{{0.13f, 0.20f, 0.30f}, {0, 0, 0}},
    kUprightLook{{0.42f, 0.42f, 0.40f}, {0, 0, 0}}, kArmLook{{0.055f, 0.055f, 0.060f}, {0.02f, 0.10f, 0.06f}},
    kBodyLook{{0.55f, 0.50f, 0.45f}, {0.01f, 0.05f, 0.02f}};

}  // namespace palpate::render
