#include "palpate/physics/organ/prepared_organ.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/physics/deformable/linear_body.h"
#include "palpate/physics/deformable/site_law.h"
#include "palpate/physics/organ/organ_cache.h"
#include "palpate/physics/organ/organ_mesh.h"
#include "palpate/physics/organ/site_answers.h"
#include "palpate/physics/organ/surface_sites.h"
#include "palpate/physics/tissue/energy_site.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate::physics::organ {
namespace {

constexpr int kDepths = 16;  // at which a site's energy is tabulated
constexpr std::size_t kFewestSites = 12;

// The share of the whole of each part, as it was measured.
class Parts {
 public:
  explicit Parts(const OrganProgress& progress) : progress_(progress) {}
  Share begin(std::string_view what, double share) {
    before_ += share_;
    share_ = share;
    tell(what, before_);
    return [this, what, from = before_, share](double done) { return tell(what, from + (share * done)); };
  }
  bool given_up() const { return given_up_; }

 private:
  bool tell(std::string_view what, double done) {
    if (progress_ && !progress_(what, done)) given_up_ = true;
    return !given_up_;
  }

  const OrganProgress& progress_;
  double before_ = 0.0, share_ = 0.0;
  bool given_up_ = false;
};

// Energies over depths that lie closer where the tip is hardly in.
tissue::EnergySite energy_site(const deformable::SiteLaw& law, const deformable::SurfaceSite& site,
                               double deepest) {
  tissue::EnergySite result{site.place, site.normal, {}, {}};
  for (int i = 1; i <= kDepths; ++i) {
    const double part = static_cast<double>(i) / kDepths, depth = deepest * part * part;
    result.depth_m.push_back(depth);
    result.energy_j.push_back(law.energy(depth));
  }
  return result;
}

// Mean curvature of the surface under a tip: by how much it falls below the tangent plane all round. A mesh's edges are
// smoothed by the tip's own size; an edge sharper than the tip counts as one of its radius.
double curvature_at(const tissue::SurfaceDistance& distance, const deformable::SurfaceSite& site,
                    double radius) {
  constexpr int kDirections = 12;
  const Vector3 side = site.normal.unitOrthogonal(), other = site.normal.cross(side);
  double fallen = 0.0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kDirections;
    fallen += distance.at(site.place + radius * (std::cos(angle) * side + std::sin(angle) * other)).distance;
  }
  return std::clamp(2.0 * fallen / (kDirections * radius * radius), -0.5 / radius, 1.0 / radius);
}

std::vector<tissue::EnergySite> energy_sites(const tissue::SurfaceDistance& distance,
                                             const std::vector<deformable::SurfaceSite>& sites,
                                             const SiteTable& body, const NoduleAnswers& nodules,
                                             const deformable::Material& material,
                                             const OrganSettings& settings) {
  std::vector<double> layers;  // above each inclusion, where it is thinnest
  for (const auto& inclusion : material.inclusions) {
    layers.push_back(std::numeric_limits<double>::infinity());
    for (const auto& site : sites)
      layers.back() = std::min(layers.back(), deformable::distance_to(inclusion, site.place));
  }
  std::vector<tissue::EnergySite> energies;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    deformable::SiteLaw law;
    law.matter = material.matrix;
    law.radius = settings.tip_radius;
    law.curvature = curvature_at(distance, sites[i], settings.tip_radius);
    law.homogeneous = body.own[i];
    if (!material.inclusions.empty()) {
      law.footprints.assign(kNoduleFootprints.begin(), kNoduleFootprints.end());
      for (Eigen::Index k = 0; k < nodules.change.cols(); ++k)
        law.inclusions.push_back(nodules.change(static_cast<Eigen::Index>(i), k));
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t n = 0; n < material.inclusions.size(); ++n) {
        const double away = deformable::distance_to(material.inclusions[n], sites[i].place);
        if (away < nearest) law.layer = layers[n];
        nearest = std::min(nearest, away);
      }
    }
    energies.push_back(energy_site(law, sites[i], settings.deepest));
  }
  return energies;
}

// Of what the surface does, what is beyond a half-space's answer.
SiteTable beyond_half_space(const OrganMesh& body, const std::vector<deformable::SurfaceSite>& sites,
                            const deformable::Elastic& matter, Eigen::MatrixXf moved) {
  SiteTable table{{}, std::move(moved)};
  const double middle = 0.75 / (matter.plane_strain() * kBodyFootprint);  // of a half-space, m/N
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    double own = 0.0, weight = 0.0;
    for (std::size_t n = 0; n < body.surface_nodes.size(); ++n) {
      const Vector3& node = body.mesh.nodes[static_cast<std::size_t>(body.surface_nodes[n])];
      const double distance = (node - sites[i].place).norm() / kBodyFootprint;
      auto moves = table.moved.col(column).segment<3>(static_cast<Eigen::Index>(3 * n));
      moves += (middle * half_space_profile(distance) * sites[i].normal).cast<float>();
      // Smooth there, so what the nodes within the disc have tells what the site has.
      const double w = distance < 1.0 ? (1.0 - distance) * (1.0 - distance) : 0.0;
      own -= w * moves.cast<double>().dot(sites[i].normal);
      weight += w;
    }
    table.own.push_back(weight > 0.0 ? own / weight : 0.0);
  }
  return table;
}

Expected<void> check_organ(const OrganSettings& s) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  if (!within(s.young_pa, 100.0, 1e6) || !within(s.poisson, 0.0, 0.495))
    return wrong_use(
        "organ: Young's modulus {} Pa and Poisson's ratio {}; 100 to 1e6 and 0 to 0.495 are expected",
        s.young_pa, s.poisson);
  if (!within(s.tip_radius, 0.001, 0.02) || !within(s.deepest, 1e-4, 2.0 * s.tip_radius))
    return wrong_use("organ: a tip of {} m, {} m deep; 0.001 to 0.02 and at most its diameter are expected",
                     s.tip_radius, s.deepest);
  if (!within(s.element, 1e-3, 0.1) || !within(s.site_spacing, 1e-3, 0.1) || !within(s.support, 0.0, 0.1))
    return wrong_use(
        "organ: elements of {} m, sites every {} m, support {} m; 0.001 to 0.1, support from 0, are expected",
        s.element, s.site_spacing, s.support);
  if (!(std::abs(s.up.norm() - 1.0) < 1e-6))
    return wrong_use("organ: an upward direction of length 1 is expected");
  for (const Nodule& n : s.nodules)
    if (!n.centre.allFinite() || !within(n.radius, 1e-4, 0.1) || !within(n.ratio, 1e-3, 1e4))
      return wrong_use(
          "organ: a nodule of radius {} m, {} times stiffer; 0.0001 to 0.1 and 0.001 to 10000 are expected",
          n.radius, n.ratio);
  return {};
}

// All that is computed, with what the cache has.
struct Work {
  const scene::TriangleMesh& surface;
  const tissue::SurfaceDistance& distance;
  const OrganSettings& settings;
  deformable::Material material;
  OrganCache cache;
  std::string body_key, whole_key;
  OrganMesh body;
  std::vector<deformable::SurfaceSite> sites;
  SiteTable dent;
};

Expected<tissue::TipField> compute(Work& work, Parts& parts) {
  const auto bare =
      deformable::linear_stiffness(work.body.mesh, {work.material.matrix, {}}, work.body.motion);
  auto answers = work.cache.body(work.body_key);
  if (answers && (answers->own.size() != work.sites.size() ||
                  answers->moved.rows() != static_cast<Eigen::Index>(3 * work.body.surface_nodes.size())))
    answers.reset();
  NoduleAnswers changes;
  if (!answers || !work.material.inclusions.empty()) {
    const auto factor = deformable::factorised(bare);
    if (!factor) return tl::unexpected(factor.error());
    const auto progress = parts.begin("body", 0.35);
    if (parts.given_up()) return given_up();
    if (!answers) {
      auto computed = body_answers(work.body, work.material.matrix, *factor, work.sites, progress);
      if (!computed) return tl::unexpected(computed.error());
      answers = std::move(*computed);
      work.cache.keep_body(work.body_key, *answers);
    }
    if (!work.material.inclusions.empty()) {
      auto found =
          nodule_answers(work.body, work.material, bare, *factor, work.sites, parts.begin("nodules", 0.3));
      if (!found) return tl::unexpected(found.error());
      changes = std::move(*found);
    }
  }
  parts.begin("field of the tip", 0.3);
  if (parts.given_up()) return given_up();
  auto field = tissue::TipField::build(
      work.surface, energy_sites(work.distance, work.sites, *answers, changes, work.material, work.settings),
      {.tip_radius = work.settings.tip_radius, .deepest = work.settings.deepest});
  if (!field) return field;
  if (changes.moved.size() > 0) answers->moved += changes.moved;
  work.dent = beyond_half_space(work.body, work.sites, work.material.matrix, std::move(answers->moved));
  work.cache.keep_whole(work.whole_key, work.dent, *field);
  return field;
}

// Whether each lies within the surface.
Expected<void> check_nodules(const tissue::SurfaceDistance& distance, const std::vector<Nodule>& nodules) {
  for (const Nodule& nodule : nodules)
    if (const double out = distance.at(nodule.centre).distance; !(out < -nodule.radius))
      return refused(
          "organ: a nodule of {:.1f} mm radius whose middle is {:.1f} mm deep; all of it is to be inside",
          1e3 * nodule.radius, -1e3 * out);
  return {};
}

}  // namespace

deformable::Material matter_of(const OrganSettings& settings) {
  deformable::Material material;
  material.matrix = {settings.young_pa, settings.poisson};
  for (const Nodule& nodule : settings.nodules)
    material.inclusions.push_back({nodule.centre, Vector3::Constant(nodule.radius), nodule.ratio});
  return material;
}

Expected<PreparedOrgan> prepare_organ(const scene::TriangleMesh& surface, const OrganSettings& settings,
                                      const OrganProgress& progress) {
  if (auto good = check_organ(settings); !good) return tl::unexpected(good.error());
  Parts parts(progress);
  parts.begin("mesh", 0.05);
  const auto distance = tissue::SurfaceDistance::of(surface);
  if (!distance) return tl::unexpected(distance.error());
  if (auto good = check_nodules(*distance, settings.nodules); !good) return tl::unexpected(good.error());
  auto body = organ_mesh(surface, *distance, settings.element, settings.up, settings.support);
  if (!body) return tl::unexpected(body.error());
  const std::string key = body_key(surface, settings);
  Work work{surface,
            *distance,
            settings,
            matter_of(settings),
            OrganCache(settings.cache),
            key,
            whole_key(key, settings),
            std::move(*body),
            surface_sites(surface, *distance, settings.site_spacing, settings.up, settings.support),
            {}};
  if (work.sites.size() < kFewestSites)
    return refused(
        "organ: {} places {:.1f} mm apart on what can be reached; at least {} are expected: take a smaller "
        "spacing",
        work.sites.size(), 1e3 * settings.site_spacing, kFewestSites);
  auto anchors = anchors_of(surface, work.body.mesh, work.body.surface_nodes);
  auto known = work.cache.field(work.whole_key);
  auto dent = known ? work.cache.dent(work.whole_key) : std::nullopt;
  const bool from_cache = dent && dent->own.size() == work.sites.size() &&
                          dent->moved.rows() == static_cast<Eigen::Index>(3 * work.body.surface_nodes.size());
  if (from_cache) {
    work.dent = std::move(*dent);
  } else {
    auto field = compute(work, parts);
    if (!field) return tl::unexpected(field.error());
    known = std::move(*field);
  }
  if (progress) progress("ready", 1.0);
  return PreparedOrgan{surface, std::move(*known),
                       DentShape(surface, std::move(anchors), {std::move(work.sites), std::move(work.dent)},
                                 settings.tip_radius),
                       from_cache};
}

}  // namespace palpate::physics::organ
