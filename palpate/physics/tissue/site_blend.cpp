#include "palpate/physics/tissue/site_blend.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::physics::tissue {
namespace {

using Basis = Eigen::Matrix<double, 6, 1>;

constexpr double kSharp = 0.02;   // of the squared reach: how nearly the fit goes through a site
constexpr double kTurned = 1e-4;  // what a site counts that faces elsewhere
constexpr double kRidge = 1e-6;   // of the weights: where sites are too few for a quadratic it stays flat

double power_25(double d) { return d * d * std::sqrt(d); }

Expected<void> check_site(const EnergySite& site, std::size_t number) {
  if (!site.place.allFinite() || !site.normal.allFinite() || std::abs(site.normal.norm() - 1.0) > 1e-6)
    return refused("site {}: a finite place and a normal of length 1 are expected", number);
  if (site.depth_m.size() != site.energy_j.size() || site.depth_m.size() < 2)
    return refused("site {}: {} depths and {} energies; as many of each, and at least two, are expected",
                   number, site.depth_m.size(), site.energy_j.size());
  double depth = 0.0, energy = 0.0;
  for (std::size_t i = 0; i < site.depth_m.size(); ++i) {
    if (!(site.depth_m[i] > depth && site.energy_j[i] > energy && std::isfinite(site.depth_m[i]) &&
          std::isfinite(site.energy_j[i])))
      return refused("site {}: entry {}, {} m and {} J: both more than 0 and rising are expected", number, i,
                     site.depth_m[i], site.energy_j[i]);
    depth = site.depth_m[i];
    energy = site.energy_j[i];
  }
  return {};
}

// The slopes of a parabola through each entry and its neighbours.
std::vector<double> slopes_of(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  const auto rise = [&](std::size_t i) { return (y[i + 1] - y[i]) / (x[i + 1] - x[i]); };
  std::vector<double> slope(n, rise(0));
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    slope[i] = (after * rise(i - 1) + before * rise(i)) / (before + after);
  }
  if (n > 2) {
    slope[0] = 2.0 * rise(0) - slope[1];
    slope[n - 1] = 2.0 * rise(n - 2) - slope[n - 2];
  }
  return slope;
}

}  // namespace

double SiteBlend::Curve::of(double d, double* slope_there) const {
  if (d <= depth.front()) {
    if (slope_there != nullptr) *slope_there = slope.front();
    return kappa.front() + slope.front() * (d - depth.front());
  }
  const auto after = std::upper_bound(depth.begin(), depth.end() - 1, d);
  const auto i = static_cast<std::size_t>(after - depth.begin()) - 1;
  const double h = depth[i + 1] - depth[i], t = std::min(1.0, (d - depth[i]) / h), s = 1.0 - t;
  if (slope_there != nullptr)
    *slope_there = 6.0 * t * s * (kappa[i + 1] - kappa[i]) / h + slope[i] * s * (s - 2.0 * t) +
                   slope[i + 1] * t * (t - 2.0 * s);
  return s * s * (1.0 + 2.0 * t) * kappa[i] + t * t * (1.0 + 2.0 * s) * kappa[i + 1] +
         h * s * t * (s * slope[i] - t * slope[i + 1]);
}

Expected<SiteBlend> SiteBlend::of(std::span<const EnergySite> sites, double deepest, double shallowest) {
  if (sites.empty()) return refused("tip field: no sites; places with their energies are expected");
  SiteBlend blend;
  blend.shallowest_ = shallowest;
  blend.deepest_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (auto good = check_site(sites[i], i); !good) return tl::unexpected<Error>(good.error());
    Site site{sites[i].place, sites[i].normal, {}};
    site.curve.depth = sites[i].depth_m;
    for (std::size_t j = 0; j < sites[i].depth_m.size(); ++j)
      site.curve.kappa.push_back(sites[i].energy_j[j] / power_25(sites[i].depth_m[j]));
    site.curve.slope = slopes_of(site.curve.depth, site.curve.kappa);
    blend.deepest_ = std::min(blend.deepest_, sites[i].depth_m.back());
    blend.sites_.push_back(std::move(site));
  }
  if (deepest > 0.0) {
    if (deepest > blend.deepest_)
      return refused("tip field: a depth of {:.2f} mm is wanted, and the sites' energies end at {:.2f} mm",
                     1e3 * deepest, 1e3 * blend.deepest_);
    blend.deepest_ = deepest;
  }
  const double d = blend.deepest_;
  for (Site& site : blend.sites_) {
    double slope = 0.0;
    const double kappa = site.curve.of(d, &slope);
    site.curve.energy = kappa * power_25(d);
    site.curve.force = 2.5 * kappa * d * std::sqrt(d) + slope * power_25(d);
    site.curve.tangent = std::max(0.0, 3.75 * kappa * std::sqrt(d) + 5.0 * slope * d * std::sqrt(d));
  }
  return blend;
}

double SiteBlend::kappa_of(const Site& site, double depth) const {
  if (depth <= deepest_) return site.curve.of(std::max(depth, shallowest_));
  const double x = depth - deepest_;
  return (site.curve.energy + site.curve.force * x + 0.5 * site.curve.tangent * x * x) / power_25(depth);
}

std::size_t SiteBlend::nearest(const Vector3& foot, std::array<Neighbour, kNeighbours + 1>& found) const {
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < sites_.size(); ++i) {
    const Neighbour n{(sites_[i].place - foot).squaredNorm(), i};
    if (count < found.size()) {
      found[count++] = n;
      std::push_heap(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count));
    } else if (n < found.front()) {
      std::pop_heap(found.begin(), found.end());
      found.back() = n;
      std::push_heap(found.begin(), found.end());
    }
  }
  std::sort_heap(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count));
  return count;
}

double SiteBlend::kappa(const Vector3& foot, const Vector3& outwards, double depth) const {
  std::array<Neighbour, kNeighbours + 1> found{};
  const std::size_t count = nearest(foot, found);
  // The next site would come in with no weight.
  const bool all = count <= kNeighbours;
  const double reach2 = std::max((all ? 1.5 : 1.0) * found[count - 1].distance2, 1e-12);
  const Vector3 x = outwards.unitOrthogonal(), y = outwards.cross(x);
  const double scale = 1.0 / std::sqrt(reach2);
  Matrix6 normal = Matrix6::Zero();
  Basis right = Basis::Zero();
  double low = std::numeric_limits<double>::infinity(), high = -low, total = 0.0;
  for (std::size_t i = 0; i < count - (all ? 0 : 1); ++i) {
    const Site& site = sites_[found[i].site];
    const double q = found[i].distance2 / reach2, fall = std::max(0.0, 1.0 - q);
    const double facing = std::max(0.0, outwards.dot(site.normal));
    const double weight = fall * fall * fall / (q + kSharp) * (facing * facing + kTurned);
    if (weight <= 0.0) continue;
    const Vector3 apart = scale * (site.place - foot);
    const double u = x.dot(apart), v = y.dot(apart), value = kappa_of(site, depth);
    const Basis row = (Basis() << 1.0, u, v, u * u, u * v, v * v).finished();
    normal.noalias() += weight * row * row.transpose();
    right += weight * value * row;
    total += weight;
    if (facing > 0.3) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (!(total > 0.0)) return kappa_nearest(foot, depth);
  const double mean = right[0] / total;
  right -= mean * normal.col(0);
  for (Eigen::Index i = 1; i < 6; ++i) normal(i, i) += kRidge * total;
  const double fitted = mean + normal.ldlt().solve(right)[0];
  if (!(low <= high)) return mean;
  // Beyond the sites a quadratic may run away; half of what they differ by is allowed.
  const double room = 0.5 * (high - low);
  return std::clamp(fitted, std::max(0.5 * low, low - room), high + room);
}

double SiteBlend::kappa_nearest(const Vector3& foot, double depth) const {
  const auto at = std::min_element(sites_.begin(), sites_.end(), [&](const Site& a, const Site& b) {
    return (a.place - foot).squaredNorm() < (b.place - foot).squaredNorm();
  });
  return kappa_of(*at, depth);
}

}  // namespace palpate::physics::tissue
