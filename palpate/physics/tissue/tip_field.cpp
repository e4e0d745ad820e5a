#include "palpate/physics/tissue/tip_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <stdexcept>
#include <utility>
#include <vector>

#include "palpate/core/file.h"
#include "palpate/core/little_endian.h"
#include "palpate/physics/tissue/site_blend.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate::physics::tissue {
namespace {

constexpr int kBorder = 5;     // cells beyond where the tip touches: what ends do to a spline has died away
constexpr double kBand = 8.0;  // spacings outside and below, over which kappa is blended
constexpr double kShallow = 2.0;  // spacings outside, down to which kappa follows the depth
constexpr double kBeyond = 0.5;   // of the deepest depth, that a tip may go beyond it before it is lost
// The gradient of a distance is 1; where it is less than this, inside, two sides are nearly equally near.
constexpr double kRidgeGradient = 0.6;

Expected<Lattice> lattice_around(const scene::TriangleMesh& surface, const TipFieldSettings& settings) {
  Vector3 low = surface.vertices.front(), high = low;
  for (const Vector3& v : surface.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const double border = settings.tip_radius + kBorder * settings.spacing;
  const Vector3 extent = high - low + Vector3::Constant(2.0 * border);
  const Vector3 cells = extent / settings.spacing;
  const double bytes = 2.0 * sizeof(float) * (cells + Vector3::Constant(2.0)).prod();
  if (!(bytes <= static_cast<double>(kMostTissueBytes)))
    return refused(
        "tip field: a body of {:.0f} x {:.0f} x {:.0f} mm at {:.2f} mm takes {:.0f} MB, and {:.0f} are "
        "allowed; choose a larger spacing",
        1e3 * extent.x(), 1e3 * extent.y(), 1e3 * extent.z(), 1e3 * settings.spacing, 1e-6 * bytes,
        1e-6 * static_cast<double>(kMostTissueBytes));
  Lattice lattice;
  lattice.spacing = settings.spacing;
  for (std::size_t i = 0; i < 3; ++i)
    lattice.count[i] = static_cast<int>(std::ceil(cells[static_cast<Eigen::Index>(i)])) + 1;
  const Vector3 whole =
      settings.spacing * Vector3(lattice.count[0] - 1, lattice.count[1] - 1, lattice.count[2] - 1);
  lattice.origin = 0.5 * (low + high) - 0.5 * whole;
  return lattice;
}

Expected<void> check_settings(const TipFieldSettings& settings) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!within(settings.tip_radius, 1e-4, 0.1))
    return wrong_use("tip field: a tip of {} m; 0.0001 to 0.1 is expected", settings.tip_radius);
  if (!within(settings.spacing, 1e-4, 0.05))
    return wrong_use("tip field: a spacing of {} m; 0.0001 to 0.05 is expected", settings.spacing);
  if (!within(settings.deepest, 0.0, 0.1) || !(settings.most_tangent_n_m > 0.0))
    return wrong_use(
        "tip field: a depth of {} m and a tangent of {} N/m; 0 to 0.1 and more than 0 are expected",
        settings.deepest, settings.most_tangent_n_m);
  return {};
}

}  // namespace

Expected<TipField> TipField::build(const scene::TriangleMesh& surface, std::span<const EnergySite> sites,
                                   const TipFieldSettings& settings) {
  if (auto good = check_settings(settings); !good) return tl::unexpected<Error>(good.error());
  const auto distance = SurfaceDistance::of(surface);
  if (!distance) return tl::unexpected<Error>(distance.error());
  const auto blend = SiteBlend::of(sites, settings.deepest, -kShallow * settings.spacing);
  if (!blend) return tl::unexpected<Error>(blend.error());
  const auto lattice = lattice_around(surface, settings);
  if (!lattice) return tl::unexpected<Error>(lattice.error());

  const double band = kBand * settings.spacing;
  // Deeper than that nobody is pushed.
  const double most = std::max(band, (1.0 + kBeyond) * blend->deepest() - settings.tip_radius + band);
  std::vector<double> depth(lattice->size()), kappa(lattice->size());
  const auto row = [&](int y, int z) {
    double side = 1.0;  // a row begins outside
    for (int x = 0; x < lattice->count[0]; ++x) {
      const Vector3 p = lattice->at(x, y, z);
      SurfacePlace place = distance->at(p, most);
      // So far from the surface a point is on the side of its neighbour.
      if (place.distance < most)
        side = place.distance < 0.0 ? -1.0 : 1.0;
      else
        place.distance = side * most;
      const double d = settings.tip_radius - place.distance;
      const bool pressed = d > -band && d < (1.0 + kBeyond) * blend->deepest() + band;
      // Seen from the tip, which around an edge is from between its sides.
      const double apart = std::abs(place.distance);
      const Vector3 outwards = apart > 1e-6 * settings.spacing
                                   ? Vector3((p - place.foot) * (place.distance < 0.0 ? -1.0 : 1.0) / apart)
                                   : place.normal;
      const std::size_t at = lattice->index(x, y, z);
      depth[at] = d;
      kappa[at] = pressed ? blend->kappa(place.foot, outwards, d) : blend->kappa_nearest(place.foot, d);
    }
  };
  const auto layers = [&](int first) {
    for (int z = first; z < lattice->count[2]; z += 2)
      for (int y = 0; y < lattice->count[1]; ++y) row(y, z);
  };
  // Two at once: it is some seconds' work, and a machine has two cores at least.
  auto others = std::async(std::launch::async, layers, 1);
  layers(0);
  others.get();
  TipField field({settings.tip_radius, blend->deepest(), 0.0, 0.0},
                 SplineFields<2>::through(*lattice, {std::move(depth), std::move(kappa)}));
  field.measure();
  if (field.facts_.stiffest_n_m > settings.most_tangent_n_m)
    return refused(
        "tip field: pressed {:.1f} mm deep with a tip of {:.1f} mm the body is {:.0f} N/m stiff somewhere, "
        "and "
        "{:.0f} can be rendered without buzzing; choose a softer material, a smaller tip or less depth",
        1e3 * field.facts_.deepest, 1e3 * settings.tip_radius, field.facts_.stiffest_n_m,
        settings.most_tangent_n_m);
  return field;
}

TipField::TipField(const TipFieldFacts& facts, SplineFields<2> fields)
    : facts_(facts), fields_(std::move(fields)), lost_depth_((1.0 + kBeyond) * facts.deepest) {
  if (!(facts.tip_radius > 0.0 && facts.deepest > 0.0 && facts.stiffest_n_m >= 0.0 &&
        facts.strongest_n >= 0.0 &&
        std::isfinite(facts.tip_radius + facts.deepest + facts.stiffest_n_m + facts.strongest_n)))
    throw std::invalid_argument(fmt::format("tip field: tip {} m, deepest {} m, {} N/m, {} N: cannot be",
                                            facts.tip_radius, facts.deepest, facts.stiffest_n_m,
                                            facts.strongest_n));
}

TipEnergy TipField::at(const Vector3& p) const {
  TipEnergy found;
  if (!fields_.lattice().covers(p)) return found;
  const auto [d, kappa] = fields_.sample(p);
  if (!(d.value > 0.0)) return found;
  const double root = std::sqrt(d.value), d15 = d.value * root, d25 = d.value * d15;
  const double steep2 = d.gradient.squaredNorm(), steep = std::sqrt(steep2);
  found.depth = d.value;
  found.energy = kappa.value * d25;
  found.force = -(2.5 * kappa.value * d15 * d.gradient + d25 * kappa.gradient);
  found.normal = steep > 1e-9 ? Vector3(-d.gradient / steep) : Vector3(Vector3::Zero());
  // The second derivative along the normal, where d is as straight as a distance is.
  found.tangent =
      std::max(0.0, 3.75 * kappa.value * root * steep2 + 5.0 * d15 * d.gradient.dot(kappa.gradient));
  found.lost = d.value > lost_depth_ || (d.value > facts_.tip_radius && steep < kRidgeGradient);
  return found;
}

// At the lattice's own points, and between them.
void TipField::measure() {
  const Lattice& lattice = fields_.lattice();
  const double step = 0.02 * lattice.spacing;
  for (int half = 0; half < 2; ++half)
    for (int z = 1; z < lattice.count[2] - 2; ++z)
      for (int y = 1; y < lattice.count[1] - 2; ++y)
        for (int x = 1; x < lattice.count[0] - 2; ++x) {
          const Vector3 p =
              lattice.at(x, y, z) + Vector3::Constant(0.5 * half * lattice.spacing + 0.001 * step);
          const TipEnergy here = at(p);
          if (here.depth <= 0.0 || here.lost) continue;
          facts_.strongest_n = std::max(facts_.strongest_n, here.force.norm());
          const TipEnergy deeper = at(p - step * here.normal);
          if (deeper.depth > facts_.deepest || deeper.lost) continue;
          facts_.stiffest_n_m = std::max(facts_.stiffest_n_m, (deeper.force - here.force).norm() / step);
        }
}

std::string tip_field_key(const scene::TriangleMesh& surface, std::span<const EnergySite> sites,
                          const TipFieldSettings& settings) {
  constexpr std::uint32_t kMethod = 1;  // counts up when the same input gives another field
  std::string bytes;
  const auto add = [&](auto number) { append_little_endian(bytes, number); };
  const auto add_vector = [&](const Vector3& v) { add(v.x()), add(v.y()), add(v.z()); };
  add(kMethod);
  for (const double number : {settings.tip_radius, settings.spacing, settings.deepest}) add(number);
  add(static_cast<std::uint64_t>(surface.vertices.size()));
  for (const Vector3& v : surface.vertices) add_vector(v);
  for (const auto& t : surface.triangles)
    for (const std::uint32_t i : t) add(i);
  for (const EnergySite& site : sites) {
    add_vector(site.place), add_vector(site.normal);
    add(static_cast<std::uint64_t>(site.depth_m.size()));
    for (const double d : site.depth_m) add(d);
    for (const double w : site.energy_j) add(w);
  }
  return content_hash(bytes);
}

}  // namespace palpate::physics::tissue
