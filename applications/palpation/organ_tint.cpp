#include "applications/palpation/organ_tint.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "applications/palpation/looks.h"
#include "palpate/physics/deformable/site_law.h"
#include "palpate/physics/deformable/surface_stress.h"

namespace palpate::applications::palpation {
namespace {

// Seen from above, in shares of the organ's half width and half depth: from place to place, half as wide as `width`, m.
struct Vein {
  std::array<double, 2> from, to;
  double width;
};
constexpr double kTrunk_m = 0.0036, kBranch_m = 0.0028, kTwig_m = 0.0022;
// A trunk along the organ, branches to both sides, twigs.
constexpr Vein kVeins[] = {
    {{-0.92, 0.05}, {-0.55, 0.16}, kBranch_m},  {{-0.55, 0.16}, {-0.18, 0.06}, kTrunk_m},
    {{-0.18, 0.06}, {0.20, 0.12}, kTrunk_m},    {{0.20, 0.12}, {0.55, -0.02}, kTrunk_m},
    {{0.55, -0.02}, {0.90, 0.10}, kBranch_m},   {{-0.55, 0.16}, {-0.66, 0.52}, kBranch_m},
    {{-0.66, 0.52}, {-0.55, 0.80}, kTwig_m},    {{-0.66, 0.52}, {-0.86, 0.66}, kTwig_m},
    {{-0.38, 0.11}, {-0.48, -0.26}, kBranch_m}, {{-0.48, -0.26}, {-0.70, -0.46}, kTwig_m},
    {{-0.48, -0.26}, {-0.36, -0.62}, kTwig_m},  {{0.02, 0.09}, {0.08, 0.46}, kBranch_m},
    {{0.08, 0.46}, {-0.08, 0.78}, kTwig_m},     {{0.08, 0.46}, {0.26, 0.74}, kTwig_m},
    {{0.20, 0.12}, {0.16, -0.28}, kBranch_m},   {{0.16, -0.28}, {-0.02, -0.62}, kTwig_m},
    {{0.16, -0.28}, {0.32, -0.66}, kTwig_m},    {{0.55, -0.02}, {0.62, 0.38}, kBranch_m},
    {{0.62, 0.38}, {0.52, 0.68}, kTwig_m},      {{0.62, 0.38}, {0.80, 0.50}, kTwig_m},
    {{0.55, -0.02}, {0.66, -0.38}, kTwig_m},    {{0.66, -0.38}, {0.58, -0.66}, kTwig_m}};

constexpr double kVeinShare = 0.75, kPaleShare = 0.80;
constexpr double kLeastArea_m2 = 1e-12;
constexpr double kPaleReach = 2.6;  // contact radii: so far from its middle something is seen

double smooth_step(double from, double to, double x) {
  const double s = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

// From a place to a straight line between two others, m.
double distance_to(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d way = b - a;
  const double along = std::clamp((p - a).dot(way) / std::max(way.squaredNorm(), 1e-12), 0.0, 1.0);
  return (p - a - along * way).norm();
}

Vector3 vertex_of(const scene::Shape& shape, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(&shape.values[i * scene::Shape::kFloatsPerVertex]).cast<double>();
}

std::vector<float> vein_shares(const scene::TriangleMesh& organ) {
  Vector3 low = Vector3::Constant(1e9), high = -low;
  for (const auto& v : organ.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const Vector3 middle = 0.5 * (low + high), half = 0.5 * (high - low);
  const auto place = [&](const std::array<double, 2>& share) {
    return Eigen::Vector2d(middle.x() + share[0] * half.x(), middle.z() + share[1] * half.z());
  };
  std::vector<float> shares;
  for (const auto& v : organ.vertices) {
    double share = 0.0;
    for (const Vein& vein : kVeins) {
      const double off = distance_to({v.x(), v.z()}, place(vein.from), place(vein.to));
      share = std::max(share, kVeinShare * (1.0 - smooth_step(0.35 * vein.width, vein.width, off)));
    }
    shares.push_back(static_cast<float>(share));
  }
  return shares;
}

}  // namespace

OrganTint::OrganTint(const scene::TriangleMesh& organ, const physics::deformable::Elastic& matter)
    : matter_(matter), area_at_(organ.vertices.size(), 0.0f) {
  auto veins = std::make_shared<scene::Tint>();
  veins->shares = vein_shares(organ);
  veins->above = kVeinColour;
  veins->below = kPaleColour;
  veins_ = std::move(veins);
  for (const auto& t : organ.triangles) {
    const Vector3 u = organ.vertices[t[1]] - organ.vertices[t[0]],
                  v = organ.vertices[t[2]] - organ.vertices[t[0]];
    const double area = 0.5 * u.cross(v).norm(), length = u.norm();
    if (!(area > kLeastArea_m2)) continue;
    const double along = u.dot(v) / length, across = 2.0 * area / length;
    const Eigen::Matrix2d edges = (Eigen::Matrix2d() << length, along, 0.0, across).finished();
    const Eigen::Matrix2d back = edges.inverse();
    Facet facet{{t[0], t[1], t[2]}, {}, static_cast<float>(area)};
    Eigen::Map<Eigen::Matrix2d>(facet.to_rest.data()) = back;
    facets_.push_back(facet);
    for (const std::uint32_t corner : t) area_at_[corner] += facet.share;
  }
}

std::shared_ptr<const scene::Tint> OrganTint::living(const scene::Shape* shape,
                                                     const TintPress& press) const {
  if (shape == nullptr || shape->vertices() != area_at_.size() || !(press.depth > 0.0)) return veins_;
  auto tint = std::make_shared<scene::Tint>(*veins_);
  const double contact = std::sqrt(press.tip_radius * press.depth);
  for (std::size_t i = 0; i < tint->shares.size(); ++i) {
    const double off = (vertex_of(*shape, i) - press.point).norm();
    if (off > kPaleReach * contact) continue;
    const double pale = 1.0 - smooth_step(contact, kPaleReach * contact, off);
    float& share = tint->shares[i];
    share = static_cast<float>((1.0 - pale) * share - pale * kPaleShare);
  }
  return tint;
}

double OrganTint::stress_of(const Facet& facet, const scene::Shape& shape, const TintPress& press) const {
  const Vector3 a = vertex_of(shape, facet.corners[0]), b = vertex_of(shape, facet.corners[1]),
                c = vertex_of(shape, facet.corners[2]);
  Eigen::Matrix<double, 3, 2> edges;
  edges << b - a, c - a;
  const Eigen::Matrix<double, 3, 2> F = edges * Eigen::Map<const Eigen::Matrix2d>(facet.to_rest.data());
  double pressure = 0.0;
  if (press.depth > 0.0) {
    const double contact = physics::deformable::footprint(press.tip_radius, press.depth);
    const double off = ((a + b + c) / 3.0 - press.point).norm() / contact;
    if (off < 1.0)
      pressure = 1.5 * press.force / (std::numbers::pi * contact * contact) * std::sqrt(1.0 - off * off);
  }
  return physics::deformable::surface_von_mises(matter_, F.transpose() * F, pressure);
}

std::shared_ptr<const scene::Tint> OrganTint::stress(const scene::Shape* shape,
                                                     const TintPress& press) const {
  auto tint = std::make_shared<scene::Tint>();
  tint->shares.assign(area_at_.size(), 0.0f);
  tint->above = kStressedColour;
  if (shape == nullptr || shape->vertices() != area_at_.size()) return tint;
  for (const Facet& facet : facets_) {
    const auto share = static_cast<float>(stress_of(facet, *shape, press) / kFullStress) * facet.share;
    for (const std::uint32_t corner : facet.corners) tint->shares[corner] += share / area_at_[corner];
  }
  return tint;
}

double OrganTint::largest(const scene::Tint& stress) {
  return stress.shares.empty() ? 0.0 : *std::max_element(stress.shares.begin(), stress.shares.end());
}

}  // namespace palpate::applications::palpation
