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

}  // namespace

Expected<PressPath> PressPath::prepare(const TetMesh& mesh, const FreeMotion& motion,
                                       const Material& material, Model model, const std::vector<int>& facets,
                                       const SurfaceSite& site, double radius) {
  PressPath path;
  path.solid_ = std::make_unique<Solid>(mesh, material, model);
  path.contact_ = std::make_unique<TipContact>(
      mesh, facets, kContactStiffness * material.matrix.young / radius, kContactParts);
  auto equilibrium = Equilibrium::prepare(mesh, *path.solid_, *path.contact_, motion);
  if (!equilibrium) return tl::unexpected(equilibrium.error());
  path.equilibrium_ = std::make_unique<Equilibrium>(std::move(*equilibrium));
  path.model_ = model;
  path.site_ = site;
  path.radius_ = radius;
  path.now_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  path.before_ = path.now_;
  return path;
}

RigidTip PressPath::tip_at(double depth) const {
  return {site_.place + (radius_ - depth) * site_.normal, site_.normal, radius_};
}

Expected<TipContact::State> PressPath::press(double depth) {
  const double way = depth - depth_;
  // A linear body needs no path: its state does not depend on where the search begins.
  const int steps =
      model_ == Model::linear ? 1 : std::max(1, static_cast<int>(std::ceil(way / (kLargestStep * radius_))));
  for (int step = 1; step <= steps; ++step)
    if (auto done = move_to(depth - way * (steps - step) / steps); !done) return tl::unexpected(done.error());
  return contact_->state(tip_at(depth), now_);
}

Expected<void> PressPath::move_to(double depth) {
  if (depth <= depth_) return {};
  Eigen::VectorXd guess = now_;
  if (depth_ > 0.0) guess += (now_ - before_) * ((depth - depth_) / (depth_ - depth_before_));
  if (!std::isfinite(solid_->energy(guess))) guess = now_;
  const auto steps = equilibrium_->solve(tip_at(depth), {}, guess);
  if (!steps)
    return refused(steps.error().code, "indentation: at a depth of {:.4g} m: {}", depth,
                   steps.error().message);
  before_ = std::exchange(now_, std::move(guess));
  depth_before_ = std::exchange(depth_, depth);
  return {};
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
