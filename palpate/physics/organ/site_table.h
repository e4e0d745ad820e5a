// Figures of sites on a body's surface: one number each, and how the surface moves for a force there. Value.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::physics::organ {

struct SiteTable {
  std::vector<double> own;  // m/N, of a site along -normal
  Eigen::MatrixXf moved;    // m/N: 3 rows a node of the mesh's surface, a column a site
};

}  // namespace palpate::physics::organ
