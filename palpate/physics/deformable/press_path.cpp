#include "palpate/physics/deformable/press_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate::physics::deformable {
namespace {

constexpr double kContactStiffness = 5000.0;  // times Young's modulus over the tip's radius, Pa/m
constexpr double kLargestStep = 0.25;         // of depth, in tip radii, from one state to the next
constexpr int kContactParts = 3;
// With friction: the first depth and the slip up to which the surface counts as held, in tip radii; each depth over the
// one before; and how nearly the forces must be those that friction was bounded by.
constexpr double kFirstDepth = 0.01, kHeldSlip = 1e-4, kDeeper = 1.2, kSameLoad = 1e-3;
constexpr int kMostWeighings = 20;

}  // namespace

Expected<PressPath> PressPath::prepare(const TetMesh& mesh, const FreeMotion& motion,
                                       const Material& material, Model model, const std::vector<int>& facets,
                                       const SurfaceSite& site, double radius, double friction) {
  PressPath path;
  path.solid_ = std::make_unique<Solid>(mesh, material, model);
  path.contact_ = std::make_unique<TipContact>(
      mesh, facets, kContactStiffness * material.matrix.young / radius, kContactParts);
  path.contact_->set_friction(friction, kHeldSlip * radius);
  auto equilibrium = Equilibrium::prepare(mesh, *path.solid_, *path.contact_, motion);
  if (!equilibrium) return tl::unexpected(equilibrium.error());
  path.equilibrium_ = std::make_unique<Equilibrium>(std::move(*equilibrium));
  path.model_ = model;
  path.site_ = site;
  path.radius_ = radius;
  path.friction_ = friction;
  path.now_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  path.before_ = path.now_;
  return path;
}

RigidTip PressPath::tip_at(double depth) const {
  return {site_.place + (radius_ - depth) * site_.normal, site_.normal, radius_};
}

Expected<TipContact::State> PressPath::press(double depth) {
  while (depth_ < depth)
    if (auto done = move_to(next_depth(depth)); !done) return tl::unexpected(done.error());
  return contact_->state(tip_at(depth), now_);
}

double PressPath::next_depth(double wanted) const {
  if (friction_ > 0.0) return std::min(wanted, std::max(kFirstDepth * radius_, kDeeper * depth_));
  // A linear body without friction needs no path: its state does not depend on where the search begins.
  if (model_ == Model::linear) return wanted;
  const double steps = std::ceil((wanted - depth_) / (kLargestStep * radius_));
  return steps > 1.0 ? wanted - (wanted - depth_) * (steps - 1.0) / steps : wanted;
}

Expected<void> PressPath::move_to(double depth) {
  Eigen::VectorXd guess = now_;
  if (depth_ > 0.0) guess += (now_ - before_) * ((depth - depth_) / (depth_ - depth_before_));
  if (!std::isfinite(solid_->energy(guess))) guess = now_;
  contact_->hold(tip_at(depth_), now_);
  if (const auto settled = settle(tip_at(depth), guess); !settled)
    return refused(settled.error().code, "indentation: at a depth of {:.4g} m: {}", depth,
                   settled.error().message);
  before_ = std::exchange(now_, std::move(guess));
  depth_before_ = std::exchange(depth_, depth);
  return {};
}

// Without friction at first, then with what the forces of the state before allow, until they stay.
Expected<void> PressPath::settle(const RigidTip& tip, Eigen::VectorXd& u) {
  if (const auto steps = equilibrium_->solve(tip, {}, u); !steps) return tl::unexpected(steps.error());
  if (!(friction_ > 0.0)) return {};
  double load = contact_->weigh(tip, u);
  for (int weighing = 0; weighing < kMostWeighings; ++weighing) {
    if (const auto steps = equilibrium_->solve(tip, {}, u); !steps) return tl::unexpected(steps.error());
    const double before = std::exchange(load, contact_->weigh(tip, u));
    if (std::abs(load - before) <= kSameLoad * load) return {};
  }
  return refused("friction does not settle after {} tries", kMostWeighings);
}

std::vector<int> facets_near(const TetMesh& mesh, const SurfaceSite& site, double reach) {
  std::vector<int> facets;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const auto place = [&](std::size_t k) -> const Vector3& {
      return mesh.nodes[static_cast<std::size_t>(mesh.facets[f][k])];
    };
    if ((place(1) - place(0)).cross(place(2) - place(0)).dot(site.normal) <= 0.0) continue;
    for (std::size_t k = 0; k < 6; ++k)
      if ((place(k) - site.place).norm() < reach) {
        facets.push_back(static_cast<int>(f));
        break;
      }
  }
  return facets;
}

}  // namespace palpate::physics::deformable
