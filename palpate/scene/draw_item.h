// What a picture shows of a virtual body: a mesh, what it looks like, and where it is. Values.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "palpate/math/so3.h"
#include "palpate/scene/mesh.h"
#include "palpate/scene/shape.h"

namespace palpate::scene {

// How a body answers to light. All shares are of linear light, not of encoded bytes, without unit, from 0 to
// 1. What a body mirrors comes on top of its colour: so that it gives back no more light than it gets, the
// largest of `colour` and mirror_edge together should stay below 1.
struct Look {
  std::array<float, 3> colour{0.50f, 0.50f, 0.50f};  // sent back in all directions: red, green, blue
  float mirror = 0.010f;       // of the room's light, mirrored where one looks straight at the body
  float mirror_edge = 0.080f;  // so much more where one looks along its surface
  float gloss = 0.050f;        // of the lamp's light, mirrored as a bright spot

  bool operator==(const Look&) const = default;
};

// Other colours for a part of a mesh: veins, marks of wear, values on a scale.
struct Tint {
  // Of each of the mesh's vertices, in their order, -1 to 1: so much of `above` (where it is positive) or of `below`
  // (negative) takes the place of the look's colour. Where there are not as many as vertices, none counts.
  std::vector<float> shares;
  std::array<float, 3> above{}, below{};  // as Look::colour
};

// A mesh at a place, World, m.
struct DrawItem {
  // Owned by the application's scene view, lives as long as it. Who changes its vertices raises its version.
  const TriangleMesh* mesh = nullptr;
  Look look{};
  Quaternion rotation = Quaternion::Identity();
  Vector3 position = Vector3::Zero();
  bool casts_shadow = true;
  // Where the mesh is a sphere round its own origin: the radius, m, above 0. Its shadow is then that of an
  // exact sphere, for less work, and a surface that it nearly touches gets less of the room's light. Any
  // other mesh throws the shadow of its triangles.
  std::optional<double> sphere_radius{};
  // The mesh is the scene's surface that deforms (Application::shape), with a vertex for each of its: what it
  // looks like at rest, and which vertices its triangles join.
  bool deforms = false;
  // How it has deformed; set by whoever draws the picture, from what the physics server sends. Where it has as
  // many vertices as the mesh, it takes the place of the mesh's vertices, their normals, rotation and position.
  // A mesh without triangles is then shown as a small square at each vertex.
  // Not changed by anyone any more.
  std::shared_ptr<const Shape> shape{};
  // Not changed by anyone any more; whoever wants others brings another.
  std::shared_ptr<const Tint> tint{};
};

// Gives the newest known shape to the items that deform.
inline void deform(std::vector<DrawItem>& items, const std::shared_ptr<const Shape>& shape) {
  for (DrawItem& item : items)
    if (item.deforms) item.shape = shape;
}

}  // namespace palpate::scene
