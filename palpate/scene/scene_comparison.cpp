#include "palpate/scene/scene_comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/text.h"

namespace palpate::scene {
namespace {

constexpr double kSameNumber = 1e-9;  // numbers that came over the network are the same ones
constexpr std::size_t kNamesSaid = 4;

std::string said(const std::string& name) { return fmt::format("'{}'", excerpt(name, 40)); }

std::optional<std::string> other_bodies(const SceneDescription& drawn, const SceneDescription& played) {
  const auto &ours = drawn.bodies, &theirs = played.bodies;
  if (theirs.size() != ours.size())
    return fmt::format("{} {}, not {}", theirs.size(), theirs.size() == 1 ? "body" : "bodies", ours.size());
  for (std::size_t i = 0; i < ours.size(); ++i)
    if (theirs[i].name != ours[i].name)
      return fmt::format("body {} {}, not {}", i, said(theirs[i].name), said(ours[i].name));
  return std::nullopt;
}

bool same_mesh(const std::optional<MeshAsset>& a, const std::optional<MeshAsset>& b) {
  if (!a || !b) return !a && !b;
  return a->hash == b->hash && std::abs(a->metres_per_unit - b->metres_per_unit) <= kSameNumber;
}

// Between places of the same number, of two lists of one length. What is no number lies nowhere.
double largest_distance(std::span<const Vector3> a, std::span<const Vector3> b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double apart = (a[i] - b[i]).norm();
    largest = std::max(largest, std::isfinite(apart) ? apart : std::numeric_limits<double>::infinity());
  }
  return largest;
}

std::string listed(const std::vector<std::string>& names) {
  std::vector<std::string> list;
  for (std::size_t i = 0; i < std::min(names.size(), kNamesSaid); ++i) list.push_back(said(names[i]));
  if (names.size() > kNamesSaid) list.push_back(fmt::format("{} more", names.size() - kNamesSaid));
  return fmt::format("{} {} missing", fmt::join(list, ", "), names.size() == 1 ? "is" : "are");
}

}  // namespace

std::optional<std::string> other_than_drawn(const SceneDescription& drawn, const SceneDescription& played) {
  if (played.application != drawn.application)
    return fmt::format("{}, not {}", excerpt(played.application, 40), excerpt(drawn.application, 40));
  std::vector<std::string> with;
  if (auto bodies = other_bodies(drawn, played)) with.push_back(std::move(*bodies));
  if (!same_mesh(drawn.mesh, played.mesh))
    with.emplace_back(!played.mesh ? "no mesh" : drawn.mesh ? "another mesh" : "a mesh");
  if (played.shape_vertices != drawn.shape_vertices)
    with.push_back(
        fmt::format("a soft surface of {} vertices, not {}", played.shape_vertices, drawn.shape_vertices));
  if (played.settings != drawn.settings) with.emplace_back("other settings");
  if ((played.carried_offset - drawn.carried_offset).norm() > kSameNumber)
    with.emplace_back("the stylus held elsewhere");
  if ((played.gravity - drawn.gravity).norm() > kSameNumber) with.emplace_back("another gravity");
  if (with.empty()) return std::nullopt;
  return fmt::format("{} with {}", excerpt(played.application, 40), fmt::join(with, ", "));
}

RigComparison compare_rigs(const SceneDescription& here, const SceneDescription& there) {
  RigComparison result;
  for (const auto& ours : here.surfaces) {
    const auto theirs = std::ranges::find(there.surfaces, ours.name, &SceneSurface::name);
    if (theirs == there.surfaces.end()) {
      result.only_here.push_back(ours.name);
    } else if (const double apart = largest_distance(ours.corners, theirs->corners); apart > result.largest) {
      result.largest = apart;
      result.farthest = ours.name;
    }
  }
  for (const auto& theirs : there.surfaces)
    if (std::ranges::find(here.surfaces, theirs.name, &SceneSurface::name) == here.surfaces.end())
      result.only_there.push_back(theirs.name);
  if (here.arm_tips.empty() || there.arm_tips.empty()) return result;
  result.other_arm = here.arm_tips.size() != there.arm_tips.size();
  if (!result.other_arm) result.arm = largest_distance(here.arm_tips, there.arm_tips);
  return result;
}

std::string RigComparison::words() const {
  std::vector<std::string> parts;
  if (other_arm) parts.emplace_back("its arm has another number of joints");
  if (arm > kSame)
    parts.push_back(
        fmt::format("equal readings of the arm put the tip {:.0f} mm from where they do here", arm * 1e3));
  if (largest > kSame)
    parts.push_back(fmt::format("{} lies {:.0f} mm from where it lies here", said(farthest), largest * 1e3));
  if (!only_here.empty()) parts.push_back(listed(only_here) + " there");
  if (!only_there.empty()) parts.push_back(listed(only_there) + " here");
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace palpate::scene
