#include "applications/palpation/liver.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "applications/palpation/settings.h"
#include "palpate/scene/ringed_mesh.h"
#include "palpate/scene/table_frame.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kHeight_m = 0.0481, kRimHeight_m = 0.0136;  // of the dome's top and of its widest place
constexpr double kFoot = 0.86;                               // share of the outline that stands on the table
constexpr double kSquare = 2.4;  // exponent of the dome's profile; 2 is an ellipse

struct Profile {  // a place on it: share of the outline's radius, height before lobes
  double share, height;
};

// The profile from the top (0) over the rim (1) and the foot (2) to the underside's middle (3).
Profile profile_at(double s) {
  const auto power = [](double x) { return std::pow(std::max(0.0, x), 2.0 / kSquare); };
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  if (s <= 1.0)
    return {power(std::sin(kQuarter * s)),
            kRimHeight_m + (kHeight_m - kRimHeight_m) * power(std::cos(kQuarter * s))};
  if (s <= 2.0) {
    const double angle = kQuarter * (s - 1.0);
    return {kFoot + (1.0 - kFoot) * std::cos(angle), kRimHeight_m * (1.0 - std::sin(angle))};
  }
  return {kFoot * (3.0 - s), 0.0};
}

// Along the profile by its length, 0 to 1 of the part from `begin` to `end`.
class EvenProfile {
 public:
  EvenProfile(double begin, double end) : begin_(begin), end_(end) {
    constexpr double kMeanRadius_m = 0.062;
    Profile before = profile_at(begin);
    for (std::size_t i = 1; i < length_.size(); ++i) {
      const Profile now = profile_at(begin + (end - begin) * static_cast<double>(i) / kParts);
      length_[i] =
          length_[i - 1] + std::hypot(kMeanRadius_m * (now.share - before.share), now.height - before.height);
      before = now;
    }
  }
  Profile at(double share) const {
    const double wanted = share * length_.back();
    const auto after = std::upper_bound(length_.begin() + 1, length_.end() - 1, wanted);
    const auto i = static_cast<double>(after - length_.begin());
    const double part = (wanted - *(after - 1)) / (*after - *(after - 1));
    return profile_at(begin_ + (end_ - begin_) * std::clamp((i - 1.0 + part) / kParts, 0.0, 1.0));
  }

 private:
  static constexpr double kParts = 2000.0;
  double begin_, end_;
  std::array<double, 2001> length_{};
};

// Seen from above: an oval, the right lobe larger, with a notch towards the person.
double outline(double angle) {
  constexpr double kWide_m = 0.0671, kDeep_m = 0.0485;
  const double c = std::cos(angle), s = std::sin(angle);
  const double oval = kWide_m * kDeep_m / std::hypot(kDeep_m * c, kWide_m * s);
  const double from_notch = std::remainder(angle + 1.75, 2.0 * std::numbers::pi);
  return oval * (1.0 + 0.07 * c - 0.03 * std::sin(2.0 * angle)) -
         0.008 * std::exp(-std::pow(from_notch / 0.30, 2));
}

// Thicker on the right; a shallow furrow between the lobes.
double thickness(double x) {
  return 1.0 + 0.26 * x / 0.067 - 0.035 * std::exp(-std::pow((x + 0.015) / 0.008, 2));
}

Vector3 liver_place(const Profile& at, double angle) {
  const double radius = at.share * outline(angle);
  const double x = radius * std::cos(angle);
  return {x, at.height * thickness(x), -radius * std::sin(angle)};
}

const scene::TriangleMesh* mesh_brought(const scene::SceneDescription& scene) {
  return scene.mesh ? scene.mesh->mesh.get() : nullptr;
}

}  // namespace

// Rings like an octahedron's: 4 vertices on the first, 4 more on each down to the rim, and back.
scene::TriangleMesh liver_mesh(std::uint32_t rings) {
  if (rings < 2) throw std::invalid_argument(fmt::format("liver: {} rings; 2 and more are expected", rings));
  const std::uint32_t half = 2 * rings;
  const EvenProfile above(0.0, 1.0), below(1.0, 3.0);
  return scene::ringed_mesh(half, [&](std::uint32_t ring, double around) {
    const double share = static_cast<double>(ring) / half;
    return liver_place(ring <= half ? above.at(share) : below.at(static_cast<double>(ring - half) / half),
                       around);
  });
}

scene::TriangleMesh pressed_mesh(const scene::SceneDescription& scene) {
  if (mesh_brought(scene) == nullptr) return liver_mesh();
  scene::TriangleMesh mesh = *mesh_brought(scene);
  const Quaternion turn = rotation_from_xyz(palpation_settings(scene).turn);
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (auto& v : mesh.vertices) {
    v = turn * v;
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const Vector3 middle(0.5 * (low.x() + high.x()), low.y(), 0.5 * (low.z() + high.z()));
  for (auto& v : mesh.vertices) v -= middle;
  return mesh;
}

Pose<World, Body> resting_place(const scene::SceneDescription& scene) {
  constexpr double kFromEdge_m = 0.11;  // of the middle, before the shift
  const scene::TableFrame table = scene::table_frame(scene);
  const Vector3 shift = palpation_settings(scene).shift;
  return {table.rotation, table.edge + shift.x() * table.right + shift.y() * table.up +
                              (shift.z() - kFromEdge_m) * table.near};
}

scene::ExploredSurface explored_surface(const scene::SceneDescription& scene) {
  const PalpationSettings settings = palpation_settings(scene);
  const Pose<World, Body> X_world_body = resting_place(scene);
  scene::ExploredSurface explored;
  explored.mesh = scene::moved(pressed_mesh(scene), X_world_body.rotation, X_world_body.translation);
  explored.tip_radius = settings.tip_radius;
  explored.press = std::min(explored.press, settings.deepest);
  explored.deepest = settings.deepest;
  explored.full_force_n = settings.rules.hard_n;
  return explored;
}

double volume_of(const scene::TriangleMesh& mesh) {
  double six = 0.0;
  for (const auto& t : mesh.triangles)
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six / 6.0;
}

}  // namespace palpate::applications::palpation
