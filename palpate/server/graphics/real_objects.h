// The real objects a rig names, with their meshes read from beside the rig file.
#pragma once

#include <vector>

#include "palpate/core/expected.h"
#include "palpate/render/compositor.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/mesh_file.h"

namespace palpate::server::graphics {

// Refused where a mesh cannot be read: with the object's name.
struct RealObjects {
  static Expected<RealObjects> read(const rig::Rig& rig);
  // What the compositor draws; lives as long as this object stays where it is.
  std::vector<render::RealBody> bodies() const;

  std::vector<scene::TriangleMesh> meshes;  // m
  std::vector<rig::RealObject> objects;
};

// As the rig says: light, and how its camera encodes; the rest as the quality says.
render::CompositorSettings picture_settings(const rig::Rig& rig, render::Quality quality);

}  // namespace palpate::server::graphics
