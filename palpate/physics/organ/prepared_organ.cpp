#include "palpate/physics/organ/prepared_organ.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "palpate/physics/deformable/site_law.h"
#include "palpate/physics/organ/organ_mesh.h"
#include "palpate/physics/organ/site_answers.h"
#include "palpate/physics/organ/surface_sites.h"
#include "palpate/physics/tissue/energy_site.h"

namespace palpate::physics::organ {
namespace {

constexpr int kDepths = 16;  // at which a site's energy is tabulated
constexpr std::size_t kFewestSites = 12;

deformable::Material matter_of(const OrganSettings& settings) {
  deformable::Material material;
  material.matrix = {settings.young_pa, settings.poisson};
  for (const Nodule& nodule : settings.nodules)
    material.inclusions.push_back({nodule.centre, Vector3::Constant(nodule.radius), nodule.ratio});
  return material;
}

// The share of the whole of each part, as it was measured.
class Parts {
 public:
  explicit Parts(const OrganProgress& progress) : progress_(progress) {}
  Share begin(std::string_view what, double share) {
    before_ += share_;
    share_ = share;
    if (progress_) progress_(what, before_);
    return [this, what, from = before_, share](double done) {
      if (progress_) progress_(what, from + share * done);
    };
  }

 private:
  const OrganProgress& progress_;
  double before_ = 0.0, share_ = 0.0;
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

std::vector<tissue::EnergySite> energy_sites(const std::vector<deformable::SurfaceSite>& sites,
                                             const BodyAnswers& body, const NoduleAnswers& nodules,
                                             const deformable::Material& material,
                                             const OrganSettings& settings) {
  std::vector<tissue::EnergySite> energies;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    deformable::SiteLaw law;
    law.matter = material.matrix;
    law.radius = settings.tip_radius;
    law.homogeneous = body.residual[i];
    if (!material.inclusions.empty()) {
      law.footprints.assign(kNoduleFootprints.begin(), kNoduleFootprints.end());
      for (Eigen::Index k = 0; k < nodules.change.cols(); ++k)
        law.inclusions.push_back(nodules.change(static_cast<Eigen::Index>(i), k));
      for (const auto& inclusion : material.inclusions)
        law.layer = std::min(law.layer, deformable::distance_to(inclusion, sites[i].place));
    }
    energies.push_back(energy_site(law, sites[i], settings.deepest));
  }
  return energies;
}

DentTable dent_table(const OrganMesh& body, const std::vector<deformable::SurfaceSite>& sites,
                     const deformable::Elastic& matter, Eigen::MatrixXf moved) {
  DentTable table{sites, {}, std::move(moved)};
  const double middle = 0.75 / (matter.plane_strain() * kBodyFootprint);  // of a half-space, m/N
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    double own = 0.0, weight = 0.0;
    for (std::size_t n = 0; n < body.surface_nodes.size(); ++n) {
      const Vector3& node = body.mesh.nodes[static_cast<std::size_t>(body.surface_nodes[n])];
      const double distance = (node - sites[i].place).norm();
      auto moves = table.rest.col(column).segment<3>(static_cast<Eigen::Index>(3 * n));
      moves += (middle * half_space_profile(distance / kBodyFootprint) * sites[i].normal).cast<float>();
      // Smooth there, so what the nodes within the disc have tells what the site has.
      const double q = distance / kBodyFootprint, w = q < 1.0 ? (1.0 - q) * (1.0 - q) : 0.0;
      own -= w * moves.cast<double>().dot(sites[i].normal);
      weight += w;
    }
    table.own.push_back(static_cast<float>(weight > 0.0 ? own / weight : 0.0));
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

}  // namespace

Expected<PreparedOrgan> prepare_organ(const scene::TriangleMesh& surface, const OrganSettings& settings,
                                      const OrganProgress& progress) {
  if (auto good = check_organ(settings); !good) return tl::unexpected(good.error());
  Parts parts(progress);
  const auto material = matter_of(settings);
  parts.begin("mesh", 0.05);
  const auto body = organ_mesh(surface, settings.element, settings.up, settings.support);
  if (!body) return tl::unexpected(body.error());
  const auto sites = surface_sites(surface, settings.site_spacing, settings.up, settings.support);
  if (sites.size() < kFewestSites)
    return refused(
        "organ: {} places {:.1f} mm apart on what can be reached; at least {} are expected: take a smaller "
        "spacing",
        sites.size(), 1e3 * settings.site_spacing, kFewestSites);
  const auto bare = deformable::linear_stiffness(body->mesh, {material.matrix, {}}, body->motion);
  const auto factor = deformable::factorised(bare);
  if (!factor) return tl::unexpected(factor.error());
  auto answers = body_answers(*body, material.matrix, *factor, sites, parts.begin("body", 0.35));
  if (!answers) return tl::unexpected(answers.error());
  NoduleAnswers changes;
  if (!material.inclusions.empty()) {
    auto found = nodule_answers(*body, material, bare, *factor, sites, parts.begin("nodules", 0.3));
    if (!found) return tl::unexpected(found.error());
    changes = std::move(*found);
    answers->moved += changes.moved;
  }
  parts.begin("field of the tip", 0.3);
  auto field = tissue::TipField::build(surface, energy_sites(sites, *answers, changes, material, settings),
                                       {.tip_radius = settings.tip_radius, .deepest = settings.deepest});
  if (!field) return tl::unexpected(field.error());
  DentShape dent(surface, anchors_of(surface, body->mesh, body->surface_nodes),
                 dent_table(*body, sites, material.matrix, std::move(answers->moved)), settings.tip_radius);
  return PreparedOrgan{surface, std::move(*field), std::move(dent), false};
}

}  // namespace palpate::physics::organ
