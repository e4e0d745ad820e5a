// A mesh made finer where it has to be, by halving edges.
//
// Always the longest edge of an element is halved, and of its neighbours first where theirs are longer, so that the
// elements keep their shape and meet face to face. Metres, the mesh's frame. Pure; it allocates.
// Source: Rivara, New longest-edge algorithms for the refinement of unstructured triangulations, Int. J. Numer. Methods
// Eng. 40 (1997).
#pragma once

#include <functional>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/tet_mesh.h"

namespace palpate::physics::deformable {

// Until no element's longest edge is longer than `longest` at its middle. `onto_surface` moves a new corner of the
// surface to where the true surface is; where that would turn an element inside out it stays. Edges become straight.
// Refused: more than 200,000 elements.
Expected<TetMesh> refined_mesh(const TetMesh& mesh, const std::function<double(const Vector3&)>& longest,
                               const std::function<Vector3(const Vector3&)>& onto_surface = {});

}  // namespace palpate::physics::deformable
