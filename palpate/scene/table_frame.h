// The real table as a frame, for what stands on it.
#pragma once

#include "palpate/scene/application.h"

namespace palpate::scene {

// World; unit vectors. A body upright on the table has `right`, `up` and `near` as its x, y and z.
struct TableFrame {
  Vector3 edge;             // the middle of the edge nearest the person, m
  Vector3 right, up, near;  // along that edge, out of the table, towards the person
  Quaternion rotation;      // of that body
};

// Throws std::invalid_argument where the scene has no surface "table".
TableFrame table_frame(const SceneDescription& scene);

}  // namespace palpate::scene
