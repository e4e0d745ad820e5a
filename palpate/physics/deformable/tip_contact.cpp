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
    Facet facet{mesh.facets[static_cast<std::size_t>(index)], {}, {}, {}, false};
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

void TipContact::set_friction(double coefficient, double held_slip) {
  friction_ = coefficient;
  held_slip_ = held_slip;
}

Eigen::Matrix<double, 6, 3> TipContact::displaced(const Facet& facet, const Eigen::VectorXd& u) {
  Eigen::Matrix<double, 6, 3> places = facet.places;
  for (int k = 0; k < 6; ++k)
    places.row(k) += u.segment<3>(3 * facet.nodes[static_cast<std::size_t>(k)]).transpose();
  return places;
}

void TipContact::hold(const RigidTip& tip, const Eigen::VectorXd& u) {
  if (!(friction_ > 0.0)) return;
  for (auto& facet : facets_) {
    const auto places = displaced(facet, u);
    facet.gripped = false;
    facet.grips.assign(facet.points.size(), {});
    for (std::size_t k = 0; k < facet.points.size(); ++k) {
      const Vector3 place = places.transpose() * facet.points[k].shape;
      facet.grips[k].from = place - tip.centre;
      facet.grips[k].touched = penetration(tip, place).depth > 0.0;
    }
  }
}

double TipContact::weigh(const RigidTip& tip, const Eigen::VectorXd& u) {
  for (auto& facet : facets_) {
    facet.gripped = false;
    for (auto& grip : facet.grips) grip.limit = 0.0;
  }
  double sum = 0.0;
  each_in_contact(tip, u, [&](const Facet& in, const Point& point, const TipPenetration& inside) {
    const double load = stiffness_ * inside.depth * point.area;
    sum += load;
    if (in.grips.empty()) return;
    auto& facet = facets_[static_cast<std::size_t>(&in - facets_.data())];
    auto& grip = facet.grips[static_cast<std::size_t>(&point - in.points.data())];
    if (!grip.touched) return;
    grip.normal = inside.normal;
    grip.limit = friction_ * load;
    facet.gripped = true;
  });
  return sum;
}

template <typename Visit>
void TipContact::each_gripped(const RigidTip& tip, const Eigen::VectorXd& u, const Visit& visit) const {
  for (const auto& facet : facets_) {
    if (!facet.gripped) continue;
    const auto places = displaced(facet, u);
    for (std::size_t k = 0; k < facet.points.size(); ++k) {
      const Grip& grip = facet.grips[k];
      if (!(grip.limit > 0.0)) continue;
      const Vector3 way = places.transpose() * facet.points[k].shape - tip.centre - grip.from;
      visit(facet, facet.points[k], grip, Vector3(way - way.dot(grip.normal) * grip.normal));
    }
  }
}

Vector3 TipContact::friction_on(const Grip& grip, const Vector3& slip) const {
  return -grip.limit / std::max(slip.norm(), held_slip_) * slip;
}

template <typename Visit>
void TipContact::each_in_contact(const RigidTip& tip, const Eigen::VectorXd& u, const Visit& visit) const {
  for (const auto& facet : facets_) {
    const auto places = displaced(facet, u);
    // A quadratic facet stays near its nodes: what is far from all of them is not looked at.
    double nearest = std::numeric_limits<double>::infinity(), extent = 0.0;
    for (int k = 0; k < 6; ++k) {
      nearest = std::min(nearest, -penetration(tip, places.row(k).transpose()).depth);
      extent = std::max(extent, (places.row(k) - places.row(0)).norm());
    }
    if (nearest > extent) continue;
    for (const auto& point : facet.points) {
      const auto inside = penetration(tip, places.transpose() * point.shape);
      if (inside.depth > 0.0) visit(facet, point, inside);
    }
  }
}

double TipContact::energy(const RigidTip& tip, const Eigen::VectorXd& u) const {
  double sum = 0.0;
  each_in_contact(tip, u, [&](const Facet&, const Point& point, const TipPenetration& inside) {
    sum += 0.5 * stiffness_ * inside.depth * inside.depth * point.area;
  });
  each_gripped(tip, u, [&](const Facet&, const Point&, const Grip& grip, const Vector3& slip) {
    const double s = slip.norm();
    sum += grip.limit * (s < held_slip_ ? 0.5 * s * s / held_slip_ : s - 0.5 * held_slip_);
  });
  return sum;
}

void TipContact::add_forces(const RigidTip& tip, const Eigen::VectorXd& u, Eigen::VectorXd& forces) const {
  each_in_contact(tip, u, [&](const Facet& facet, const Point& point, const TipPenetration& inside) {
    const Vector3 push = (stiffness_ * inside.depth * point.area) * inside.normal;
    for (int k = 0; k < 6; ++k)
      forces.segment<3>(3 * facet.nodes[static_cast<std::size_t>(k)]) -= point.shape[k] * push;
  });
  each_gripped(tip, u, [&](const Facet& facet, const Point& point, const Grip& grip, const Vector3& slip) {
    const Vector3 hold = friction_on(grip, slip);
    for (int k = 0; k < 6; ++k)
      forces.segment<3>(3 * facet.nodes[static_cast<std::size_t>(k)]) -= point.shape[k] * hold;
  });
}

// The second derivatives of a facet's points, gathered before they go into the matrix.
class TipContact::Blocks {
 public:
  Blocks(const FreeMotion& motion, SymmetricMatrix& matrix) : motion_(motion), matrix_(matrix) {}
  ~Blocks() { put(); }
  Blocks(const Blocks&) = delete;
  Blocks& operator=(const Blocks&) = delete;

  void add(const Facet& facet, const Point& point, const Matrix3& local) {
    if (&facet != current_) {
      put();
      current_ = &facet;
    }
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) block_.block<3, 3>(3 * a, 3 * b) += point.shape[a] * point.shape[b] * local;
  }

 private:
  void put() {
    if (current_ != nullptr) add_block(current_->nodes.data(), block_, motion_, matrix_);
    block_.setZero();
  }

  const FreeMotion& motion_;
  SymmetricMatrix& matrix_;
  const Facet* current_ = nullptr;
  Eigen::Matrix<double, 18, 18> block_ = Eigen::Matrix<double, 18, 18>::Zero();
};

void TipContact::add_stiffness(const RigidTip& tip, const Eigen::VectorXd& u, const FreeMotion& motion,
                               bool curved, SymmetricMatrix& matrix, double share) const {
  Blocks blocks(motion, matrix);
  each_in_contact(tip, u, [&](const Facet& facet, const Point& point, const TipPenetration& inside) {
    Matrix3 local = inside.normal * inside.normal.transpose();
    if (curved) local += inside.depth * inside.curvature;
    blocks.add(facet, point, share * stiffness_ * point.area * local);
  });
  each_gripped(tip, u, [&](const Facet& facet, const Point& point, const Grip& grip, const Vector3& slip) {
    const double s = slip.norm();
    Matrix3 local = Matrix3::Identity() - grip.normal * grip.normal.transpose();
    if (s >= held_slip_) local -= slip / s * (slip / s).transpose();  // along its way it costs no more
    blocks.add(facet, point, share * grip.limit / std::max(s, held_slip_) * local);
  });
}

TipContact::State TipContact::state(const RigidTip& tip, const Eigen::VectorXd& u) const {
  State state;
  each_in_contact(tip, u, [&](const Facet& facet, const Point& point, const TipPenetration& inside) {
    state.force -= (stiffness_ * inside.depth * point.area) * inside.normal;
    const Vector3 from = facet.places.transpose() * point.shape - tip.centre;
    state.radius = std::max(state.radius, (from - from.dot(tip.shaft) * tip.shaft).norm());
  });
  each_gripped(tip, u, [&](const Facet&, const Point&, const Grip& grip, const Vector3& slip) {
    state.force -= friction_on(grip, slip);
  });
  return state;
}

}  // namespace palpate::physics::deformable
