#include "palpate/physics/organ/full_press.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/physics/deformable/half_space.h"
#include "palpate/physics/deformable/press_path.h"
#include "palpate/physics/deformable/refined_mesh.h"
#include "palpate/physics/organ/organ_mesh.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate::physics::organ {
namespace {

constexpr double kGrowing = 0.5;    // longest edge over the distance beyond the contact
constexpr double kOfNodule = 0.6;   // longest edge over the nodule's radius, where it matters
constexpr double kMatters = 0.025;  // m, from the place to a nodule's surface
constexpr double kMargin = 1.1;     // of the widest contact, that may be touched

}  // namespace

Expected<FullPress> full_press(const scene::TriangleMesh& surface, const OrganSettings& settings,
                               const deformable::SurfaceSite& site, const std::vector<double>& depths,
                               double fineness) {
  if (depths.empty() || !std::is_sorted(depths.begin(), depths.end()) || !(depths.front() > 0.0) ||
      !(fineness > 0.0))
    return wrong_use("full press: rising depths of more than 0 and a fineness of more than 0 are expected");
  const auto distance = tissue::SurfaceDistance::of(surface);
  if (!distance) return tl::unexpected(distance.error());
  const auto coarse = organ_mesh(surface, *distance, settings.element, settings.up, settings.support);
  if (!coarse) return tl::unexpected(coarse.error());
  const auto contact = [&](double depth) {
    return std::min(deformable::hertz_contact_radius(settings.tip_radius, depth), settings.tip_radius);
  };
  const double widest = contact(depths.back()), finest = contact(depths.front()) / fineness;
  const auto longest = [&](const Vector3& p) {
    double wanted = finest + kGrowing * std::max(0.0, (p - site.place).norm() - widest);
    for (const Nodule& nodule : settings.nodules)
      if ((nodule.centre - site.place).norm() < nodule.radius + kMatters)
        wanted = std::min(wanted, std::max(kOfNodule * nodule.radius,
                                           std::abs((p - nodule.centre).norm() - nodule.radius)));
    return wanted;
  };
  auto fine =
      deformable::refined_mesh(coarse->mesh, longest, [&](const Vector3& p) { return distance->at(p).foot; });
  if (!fine) return tl::unexpected(fine.error());
  const auto body = lay_down(std::move(*fine), surface, settings.element, settings.up, settings.support);
  if (!body) return tl::unexpected(body.error());
  auto path = deformable::PressPath::prepare(
      body->mesh, body->motion, matter_of(settings), deformable::Model::neo_hookean,
      deformable::facets_near(body->mesh, site, kMargin * widest), site, settings.tip_radius);
  if (!path) return tl::unexpected(path.error());
  FullPress result;
  result.nodes = body->mesh.nodes.size();
  for (const double depth : depths) {
    const auto state = path->press(depth);
    if (!state) return tl::unexpected(state.error());
    result.states.push_back({depth, state->force, state->radius});
  }
  return result;
}

}  // namespace palpate::physics::organ
