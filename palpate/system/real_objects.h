// The real objects a rig names, with their meshes read from beside the rig file.
#pragma once

#include <vector>

#include "palpate/compositor/compositor.h"
#include "palpate/core/expected.h"
#include "palpate/model/rig.h"
#include "palpate/scene/mesh_file.h"

namespace palpate {

// Refused where a mesh cannot be read: with the object's name.
struct RealObjects {
  static Expected<RealObjects> read(const Rig& rig);
  // What the compositor draws; lives as long as this object stays where it is.
  std::vector<RealBody> bodies() const;

  std::vector<TriangleMesh> meshes;  // m
  std::vector<RealObject> objects;
};

// As the rig says: light, and how its camera encodes; the rest as the quality says.
CompositorSettings picture_settings(const Rig& rig, Quality quality);

}  // namespace palpate
