#include "applications/palpation/block_forces.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/physics/deformable/quick_indentation.h"

namespace palpate::applications::palpation {
namespace {

namespace deformable = physics::deformable;

constexpr double kForceExponent = 1.5;  // of force over depth
constexpr double kBlockYoung_pa = 6000.0, kBlockPoisson = 0.45;
constexpr double kBlockWidth_m = 0.106347, kBlockHeight_m = 0.050;
constexpr double kTickFineness = 2.5, kLinearFineness = 3.0;  // of the meshes
constexpr int kTickDepths = 12;
constexpr double kDeepestTabled_m = 0.006;

deformable::Indentation bare_block() {
  deformable::Indentation it;
  it.material.matrix = {kBlockYoung_pa, kBlockPoisson};
  it.size = {kBlockWidth_m, kBlockWidth_m, kBlockHeight_m};
  it.radius = kBlockTip_m;
  it.depths = {kBlockPress_m};
  it.fineness = kTickFineness;
  return it;
}

std::vector<deformable::Inclusion> inclusion_of(const BlockNodule& nodule, double beside) {
  const double radius = 0.5 * nodule.diameter;
  return {{{beside, 0.0, -(nodule.top + radius)}, Vector3::Constant(radius), nodule.ratio}};
}

ForceCurve tick_curve(const deformable::SiteLaw& law) {
  std::vector<double> depths, forces;
  for (int i = 1; i <= kTickDepths; ++i) {
    depths.push_back(kDeepestTabled_m * i / kTickDepths);
    forces.push_back(law.force(depths.back()));
  }
  return {std::move(depths), forces};
}

Expected<ForceCurve> linear_curve(deformable::Indentation it) {
  it.model = deformable::Model::linear;
  it.depths = {0.0012, 0.0022, 0.0035, 0.0050};  // contacts that one mesh suits
  it.fineness = kLinearFineness;
  const auto points = deformable::solve_indentation(it);
  if (!points) return tl::unexpected(points.error());
  std::vector<double> forces;
  for (const auto& point : *points) forces.push_back(point.force);
  return ForceCurve(it.depths, forces);
}

}  // namespace

ForceCurve::ForceCurve(std::vector<double> depths, const std::vector<double>& forces)
    : depths_(std::move(depths)) {
  if (depths_.empty() || depths_.size() != forces.size())
    throw std::invalid_argument("force curve: as many forces as depths are expected");
  for (std::size_t i = 0; i < forces.size(); ++i) {
    if (!(forces[i] > 0.0) || !(depths_[i] > (i > 0 ? depths_[i - 1] : 0.0)))
      throw std::invalid_argument("force curve: rising depths and forces above 0 are expected");
    log_stiffness_.push_back(std::log(forces[i]) - kForceExponent * std::log(depths_[i]));
  }
}

ForceCurve ForceCurve::between(const ForceCurve& first, const ForceCurve& second, double share) {
  if (first.depths_ != second.depths_)
    throw std::invalid_argument("force curve: curves of the same depths are expected");
  ForceCurve curve = first;
  for (std::size_t i = 0; i < curve.log_stiffness_.size(); ++i)
    curve.log_stiffness_[i] += share * (second.log_stiffness_[i] - first.log_stiffness_[i]);
  return curve;
}

ForceCurve ForceCurve::times(double ratio) const {
  ForceCurve curve = *this;
  for (double& log_stiffness : curve.log_stiffness_) log_stiffness += std::log(ratio);
  return curve;
}

double ForceCurve::log_at(double depth) const {
  const auto after = std::upper_bound(depths_.begin(), depths_.end(), depth);
  double log_stiffness = 0.0;
  if (after == depths_.begin()) {
    log_stiffness = log_stiffness_.front();
  } else if (after == depths_.end()) {
    log_stiffness = log_stiffness_.back();
  } else {
    const auto i = static_cast<std::size_t>(after - depths_.begin());
    const double share = (depth - depths_[i - 1]) / (depths_[i] - depths_[i - 1]);
    log_stiffness = log_stiffness_[i - 1] + share * (log_stiffness_[i] - log_stiffness_[i - 1]);
  }
  return log_stiffness + kForceExponent * std::log(depth);
}

double ForceCurve::at(double depth) const { return depth > 0.0 ? std::exp(log_at(depth)) : 0.0; }

Expected<std::vector<ForceCurve>> forces_on_block(std::span<const BlockNodule> nodules, BlockMatter matter,
                                                  const std::function<void(std::size_t)>& done) {
  std::vector<std::vector<deformable::Inclusion>> sets(1);
  for (const auto& nodule : nodules) sets.push_back(inclusion_of(nodule, 0.0));
  std::vector<ForceCurve> curves;
  if (matter == BlockMatter::neo_hookean) {
    const auto laws = deformable::site_laws_of_block(bare_block(), sets, done);
    if (!laws) return tl::unexpected(laws.error());
    for (const auto& law : *laws) curves.push_back(tick_curve(law));
    return curves;
  }
  for (const auto& set : sets) {
    auto it = bare_block();
    it.material.inclusions = set;
    auto curve = linear_curve(std::move(it));
    if (!curve) return tl::unexpected(curve.error());
    curves.push_back(std::move(*curve));
    if (done) done(curves.size());
  }
  return curves;
}

double ContrastProfile::node(int k) const {
  const auto at = static_cast<std::size_t>(std::abs(k));
  if (at < contrasts_.size()) return contrasts_[at];
  const double last = std::max(1.0, static_cast<double>(contrasts_.size()) - 1.0);
  return contrasts_.back() * std::max(0.0, 2.0 - static_cast<double>(at) / last);
}

// Catmull and Rom's cubic: beside its middle a nodule is felt as far to the left as to the right, so the curve is flat there.
double ContrastProfile::at(double beside) const {
  if (contrasts_.empty()) return 0.0;
  const double place = beside / step_;
  const int k = static_cast<int>(place);
  const double u = place - k, before = node(k - 1), here = node(k), after = node(k + 1), beyond = node(k + 2);
  const double slope = 0.5 * (after - before), bend = before - 2.5 * here + 2.0 * after - 0.5 * beyond,
               twist = 1.5 * (here - after) + 0.5 * (beyond - before);
  return std::max(0.0, here + u * (slope + u * (bend + u * twist)));
}

Expected<std::vector<ContrastProfile>> contrast_profiles(std::span<const BlockNodule> nodules, int steps,
                                                         const std::function<void(std::size_t)>& done) {
  std::vector<std::vector<deformable::Inclusion>> sets(1);
  for (const auto& nodule : nodules)
    for (int k = 0; k < steps; ++k) sets.push_back(inclusion_of(nodule, k * ContrastProfile::kStep_m));
  const auto laws = deformable::site_laws_of_block(bare_block(), sets, done);
  if (!laws) return tl::unexpected(laws.error());
  const double bare = laws->front().force(kBlockPress_m);
  std::vector<ContrastProfile> profiles;
  std::size_t next = 1;
  for (std::size_t i = 0; i < nodules.size(); ++i) {
    std::vector<double> contrasts;
    for (int k = 0; k < steps; ++k)
      contrasts.push_back(std::log((*laws)[next++].force(kBlockPress_m) / bare));
    profiles.emplace_back(std::move(contrasts));
  }
  return profiles;
}

}  // namespace palpate::applications::palpation
