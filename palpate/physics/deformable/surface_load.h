// A unit force spread over a disc of a body's surface as Hertz's pressure is, and what the body answers.
//
// The pressure is a function of the distance from the site's normal and acts along it, integrated over the surface
// that faces it. The answer f.u is the displacement that the force does its work along, m/N. SI, the body's frame.
// Pure functions; they allocate. Source: Johnson, Contact Mechanics, section 3.4: a half-space answers 3/(5 a E*).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/solid.h"

namespace palpate::physics::deformable {

struct SurfaceSite {
  Vector3 place{0.0, 0.0, 0.0};
  Vector3 normal{0.0, 0.0, 1.0};  // unit, outwards
};

// 3 per node. Where part of the disc lies beside the surface, that part of the force is missing: as it is in a
// mesh of a half or a quarter of a symmetric body.
Eigen::VectorXd hertz_load(const TetMesh& mesh, const SurfaceSite& site, double radius);

// f.u of each load, in blocks of columns.
Expected<std::vector<double>> answers(const SparseFactor& factor, const FreeMotion& motion,
                                      const std::vector<Eigen::VectorXd>& loads);

// What a half-space answers.
double half_space_answer(const Elastic& matter, double radius);

}  // namespace palpate::physics::deformable
