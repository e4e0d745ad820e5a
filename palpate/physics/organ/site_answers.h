// What a body answers to loads at its sites, by linear elasticity on its own mesh: without nodules, and what nodules
// change of it.
//
// Loads are of one newton along -normal, spread as Hertz's pressure over a disc and laid onto the mesh's surface.
// SI. Seconds; they allocate.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/linear_body.h"
#include "palpate/physics/deformable/surface_load.h"
#include "palpate/physics/organ/organ_mesh.h"
#include "palpate/physics/organ/site_table.h"

namespace palpate::physics::organ {

using Share = std::function<bool(double)>;  // of this part that is done; false: it is given up

// What a step refuses that its caller has given up.
inline tl::unexpected<Error> given_up() {
  return refused("organ: stopped before it was ready; start it again");
}

inline constexpr double kBodyFootprint = 0.012;  // m, which meshes of 10 mm resolve
inline constexpr std::array<double, 4> kNoduleFootprints{0.003, 0.005, 0.0075, 0.010};  // m

// `own`: f.u less what a half-space answers.
Expected<SiteTable> body_answers(const OrganMesh& body, const deformable::Elastic& matter,
                                 const deformable::SparseFactor& factor,
                                 const std::vector<deformable::SurfaceSite>& sites, const Share& progress);

struct NoduleAnswers {
  Eigen::MatrixXd change;  // m/N, of f.u: a row a site, a column a footprint of kNoduleFootprints
  Eigen::MatrixXf moved;   // as in a SiteTable, what is added
};
Expected<NoduleAnswers> nodule_answers(const OrganMesh& body, const deformable::Material& material,
                                       const deformable::SymmetricMatrix& bare,
                                       const deformable::SparseFactor& factor,
                                       const std::vector<deformable::SurfaceSite>& sites,
                                       const Share& progress);

}  // namespace palpate::physics::organ
