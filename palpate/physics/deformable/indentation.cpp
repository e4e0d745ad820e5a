#include "palpate/physics/deformable/indentation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "palpate/physics/deformable/block.h"
#include "palpate/physics/deformable/half_space.h"
#include "palpate/physics/deformable/press_path.h"

namespace palpate::physics::deformable {
namespace {

constexpr double kSpread = 2.3;  // depths with contacts within this factor share a mesh
constexpr double kReach = 1.05;  // of the widest contact, within which the top may be touched

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
    const SurfaceSite middle;
    auto path = PressPath::prepare(block_->mesh, block_->motion, it_.material, it_.model,
                                   facets_near(block_->mesh, middle, kReach * widest_), middle, it_.radius,
                                   it_.friction);
    if (!path) return tl::unexpected(path.error());
    path_ = std::make_unique<PressPath>(std::move(*path));
    return {};
  }

  Expected<IndentationPoint> press(double depth) {
    const auto state = path_->press(depth);
    if (!state) return tl::unexpected(state.error());
    return IndentationPoint{depth, block_->copies * state->force.z(), state->radius};
  }

 private:
  const Indentation& it_;
  double widest_;
  std::unique_ptr<Block> block_;
  std::unique_ptr<PressPath> path_;
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
  if (!(it.friction >= 0.0 && it.friction <= 10.0))
    return wrong_use("indentation: a coefficient of friction of {}; 0 to 10 is expected", it.friction);
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
