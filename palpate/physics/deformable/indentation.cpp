#include "palpate/physics/deformable/indentation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "palpate/physics/deformable/block.h"
#include "palpate/physics/deformable/box_mesh.h"
#include "palpate/physics/deformable/equilibrium.h"
#include "palpate/physics/deformable/half_space.h"

namespace palpate::physics::deformable {
namespace {

constexpr double kContactStiffness = 5000.0;  // times Young's modulus over the tip's radius, Pa/m
constexpr double kLargestStep = 0.25;         // of depth, in tip radii, from one state to the next
constexpr double kSpread = 2.3;               // depths with contacts within this factor share a mesh
constexpr int kContactParts = 3;

// As deep as this the contact is at most about so wide: Hertz's radius is the widest of all models.
double widest_contact(const Indentation& it, double depth) {
  return std::min(hertz_contact_radius(it.radius, depth), 1.05 * it.radius);
}

// One mesh, and the states on it from the shallowest to the deepest.
class Press {
 public:
  Press(const Indentation& it, double deepest) : it_(it), widest_(widest_contact(it, deepest)) {}

  Expected<void> prepare() {
    auto block = mesh_block(it_, widest_);
    if (!block) return tl::unexpected(block.error());
    block_ = std::make_unique<Block>(std::move(*block));
    solid_ = std::make_unique<Solid>(block_->mesh, it_.material, it_.model);
    contact_ = std::make_unique<TipContact>(block_->mesh, facets_within_reach(),
                                            kContactStiffness * it_.material.matrix.young / it_.radius,
                                            kContactParts);
    auto equilibrium = Equilibrium::prepare(block_->mesh, *solid_, *contact_, block_->motion);
    if (!equilibrium) return tl::unexpected(equilibrium.error());
    equilibrium_ = std::make_unique<Equilibrium>(std::move(*equilibrium));
    now_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * block_->mesh.nodes.size()));
    before_ = now_;
    return {};
  }

  Expected<IndentationPoint> press(double depth) {
    const double way = depth - depth_;
    // A linear body needs no path: its state does not depend on where the search begins.
    const int steps = it_.model == Model::linear
                          ? 1
                          : std::max(1, static_cast<int>(std::ceil(way / (kLargestStep * it_.radius))));
    for (int step = 1; step <= steps; ++step)
      if (auto done = move_to(depth - way * (steps - step) / steps); !done)
        return tl::unexpected(done.error());
    const auto state = contact_->state(tip_at(depth), now_);
    return IndentationPoint{depth, block_->copies * state.force.z(), state.radius};
  }

 private:
  RigidTip tip_at(double depth) const {
    return {{0.0, 0.0, it_.radius - depth}, {0.0, 0.0, 1.0}, it_.radius};
  }

  Expected<void> move_to(double depth) {
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

  std::vector<int> facets_within_reach() const {
    const double reach = 1.05 * widest_;
    std::vector<int> facets;
    for (const int facet : facets_on_plane(block_->mesh, 2, 0.0))
      for (const int node : block_->mesh.facets[static_cast<std::size_t>(facet)])
        if (block_->mesh.nodes[static_cast<std::size_t>(node)].norm() < reach) {
          facets.push_back(facet);
          break;
        }
    return facets;
  }

  const Indentation& it_;
  double widest_;
  std::unique_ptr<Block> block_;
  std::unique_ptr<Solid> solid_;
  std::unique_ptr<TipContact> contact_;
  std::unique_ptr<Equilibrium> equilibrium_;
  Eigen::VectorXd now_, before_;
  double depth_ = 0.0, depth_before_ = 0.0;
};

}  // namespace

Expected<void> check(const Indentation& it) {
  if (auto good = check(it.material); !good) return good;
  if (!(it.material.matrix.poisson >= 0.0 && it.material.matrix.poisson <= 0.495))
    return wrong_use("indentation: Poisson's ratio is {}; 0 to 0.495 is expected",
                     it.material.matrix.poisson);
  if (!(it.radius > 0.0 && std::isfinite(it.radius)))
    return wrong_use("indentation: the tip's radius is {} m; a positive one is expected", it.radius);
  if (!(it.size.minCoeff() > 0.0 && it.size.allFinite()))
    return wrong_use("indentation: the block's size is {} m; positive lengths are expected",
                     it.size.minCoeff());
  if (it.depths.empty()) return wrong_use("indentation: no depth; at least one is expected");
  const double most = std::min(0.6 * it.size.z(), 1.5 * it.radius);
  for (const double depth : it.depths)
    if (!(depth > 0.0 && depth <= most))
      return wrong_use(
          "indentation: a depth of {} m; more than 0 and at most {:.4g} m is expected here (1.5 tip radii, "
          "0.6 heights)",
          depth, most);
  if (std::min(it.size.x(), it.size.y()) < 4.0 * it.radius)
    return wrong_use("indentation: the block is {:.4g} m wide; at least 4 tip radii are expected",
                     std::min(it.size.x(), it.size.y()));
  if (!(it.fineness >= 1.0 && it.fineness <= 20.0))
    return wrong_use("indentation: fineness {}; 1 to 20 is expected", it.fineness);
  for (const auto& inclusion : it.material.inclusions)
    if (inclusion.centre.z() + inclusion.radii.z() > 0.0)
      return wrong_use("indentation: an inclusion reaches out of the block's top");
  return {};
}

Expected<std::vector<IndentationPoint>> solve_indentation(const Indentation& indentation,
                                                          const std::function<void(double)>& progress) {
  if (auto good = check(indentation); !good) return tl::unexpected(good.error());
  const auto& depths = indentation.depths;
  std::vector<std::size_t> order(depths.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return depths[a] > depths[b]; });
  std::vector<IndentationPoint> points(depths.size());
  std::size_t done = 0;
  // From the deepest down: the elements of a mesh suit its deepest contact.
  for (std::size_t first = 0; first < order.size();) {
    const double deepest = depths[order[first]];
    std::size_t end = first + 1;
    while (end < order.size() &&
           widest_contact(indentation, depths[order[end]]) * kSpread > widest_contact(indentation, deepest))
      ++end;
    Press press(indentation, deepest);
    if (auto good = press.prepare(); !good) return tl::unexpected(good.error());
    for (std::size_t k = end; k-- > first;) {
      const auto point = press.press(depths[order[k]]);
      if (!point) return tl::unexpected(point.error());
      points[order[k]] = *point;
      if (progress) progress(static_cast<double>(++done) / static_cast<double>(depths.size()));
    }
    first = end;
  }
  return points;
}

}  // namespace palpate::physics::deformable
