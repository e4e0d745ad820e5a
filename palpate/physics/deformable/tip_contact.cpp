#include "palpate/physics/deformable/tip_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

namespace palpate::physics::deformable {
TipPenetration penetration(const RigidTip& tip, const Vector3& place) {
  Vector3 from = place - tip.centre;
  Matrix3 across = Matrix3::Identity();
  const double along = from.dot(tip.shaft);
  if (along > 0.0) {
    from -= along * tip.shaft;
    across -= tip.shaft * tip.shaft.transpose();
  }
  const double distance = from.norm();
  TipPenetration result;
  result.depth = tip.radius - distance;
  if (!(distance > 0.0)) return result;
  result.normal = from / distance;
  result.curvature = -(across - result.normal * result.normal.transpose()) / distance;
  return result;
}

TipContact::TipContact(const TetMesh& mesh, const std::vector<int>& facets, double stiffness, int parts)
    : stiffness_(stiffness) {
  const auto rule = divided_facet_rule(parts);
  for (const int index : facets) {
    Facet facet{mesh.facets[static_cast<std::size_t>(index)], {}, {}};
    facet.places = places_of(mesh, facet.nodes);
    for (const auto& point : rule) {
      const Eigen::Matrix<double, 3, 2> t = facet.places.transpose() * facet_shape_derivatives(point.L);
      facet.points.push_back(
          {facet_shape(point.L), 0.5 * point.weight * Vector3(t.col(0)).cross(Vector3(t.col(1))).norm()});
    }
    nodes_.insert(nodes_.end(), facet.nodes.begin(), facet.nodes.end());
    facets_.push_back(std::move(facet));
  }
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
}

template <typename Visit>
void TipContact::each_in_contact(const RigidTip& tip, const Eigen::VectorXd& u, const Visit& visit) const {
  for (const auto& facet : facets_) {
    Eigen::Matrix<double, 6, 3> displaced = facet.places;
    for (int k = 0; k < 6; ++k)
      displaced.row(k) += u.segment<3>(3 * facet.nodes[static_cast<std::size_t>(k)]).transpose();
    // A quadratic facet stays near its nodes: what is far from all of them is not looked at.
    double nearest = std::numeric_limits<double>::infinity(), extent = 0.0;
    for (int k = 0; k < 6; ++k) {
      nearest = std::min(nearest, -penetration(tip, displaced.row(k).transpose()).depth);
      extent = std::max(extent, (displaced.row(k) - displaced.row(0)).norm());
    }
    if (nearest > extent) continue;
    for (const auto& point : facet.points) {
      const auto inside = penetration(tip, displaced.transpose() * point.shape);
      if (inside.depth > 0.0) visit(facet, point, inside);
    }
  }
}

double TipContact::energy(const RigidTip& tip, const Eigen::VectorXd& u) const {
  double sum = 0.0;
  each_in_contact(tip, u, [&](const Facet&, const Point& point, const TipPenetration& inside) {
    sum += 0.5 * stiffness_ * inside.depth * inside.depth * point.area;
  });
  return sum;
}

void TipContact::add_forces(const RigidTip& tip, const Eigen::VectorXd& u, Eigen::VectorXd& forces) const {
  each_in_contact(tip, u, [&](const Facet& facet, const Point& point, const TipPenetration& inside) {
    const Vector3 push = (stiffness_ * inside.depth * point.area) * inside.normal;
    for (int k = 0; k < 6; ++k)
      forces.segment<3>(3 * facet.nodes[static_cast<std::size_t>(k)]) -= point.shape[k] * push;
  });
}

void TipContact::add_stiffness(const RigidTip& tip, const Eigen::VectorXd& u, const FreeMotion& motion,
                               bool curved, SymmetricMatrix& matrix, double share) const {
  using FacetBlock = Eigen::Matrix<double, 18, 18>;
  const Facet* current = nullptr;
  FacetBlock block = FacetBlock::Zero();
  const auto flush = [&] {
    if (current != nullptr) add_block(current->nodes.data(), block, motion, matrix);
    block.setZero();
  };
  each_in_contact(tip, u, [&](const Facet& facet, const Point& point, const TipPenetration& inside) {
    if (&facet != current) {
      flush();
      current = &facet;
    }
    Matrix3 local = inside.normal * inside.normal.transpose();
    if (curved) local += inside.depth * inside.curvature;
    local *= share * stiffness_ * point.area;
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) block.block<3, 3>(3 * a, 3 * b) += point.shape[a] * point.shape[b] * local;
  });
  flush();
}

TipContact::State TipContact::state(const RigidTip& tip, const Eigen::VectorXd& u) const {
  State state;
  each_in_contact(tip, u, [&](const Facet& facet, const Point& point, const TipPenetration& inside) {
    state.force -= (stiffness_ * inside.depth * point.area) * inside.normal;
    const Vector3 from = facet.places.transpose() * point.shape - tip.centre;
    state.radius = std::max(state.radius, (from - from.dot(tip.shaft) * tip.shaft).norm());
  });
  return state;
}

}  // namespace palpate::physics::deformable
