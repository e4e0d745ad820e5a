// The tick on a liver-like organ beside the full neo-Hookean solution on a mesh that is refined under the tip: at random
// places of the upper side, above and beside nodules, on slopes up to 30 degrees and near the rim, three depths each.
//
// usage: organ_places TABLE [PLACES [SEED]]
// TABLE: CSV, a line for each place and depth; places that are in it already are not computed again, so that hours of
// computing may be interrupted. scripts/organ-places builds, runs and draws it. A place without equilibrium is said in
// its line (`what`), not left out.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "applications/palpation/liver.h"
#include "applications/palpation/nodules.h"
#include "palpate/core/random.h"
#include "palpate/physics/organ/full_press.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate {
namespace {

namespace organ = physics::organ;
namespace palpation = applications::palpation;
using physics::deformable::SurfaceSite;

const std::vector<double> kDepths{0.0015, 0.003, 0.0045};  // m
constexpr double kSteepest = 30.0, kFlat = 10.0;           // degrees
constexpr double kBeside = 0.010;                          // m, from a nodule's rim, seen from above
constexpr double kRim = 0.015;                             // m, to where the surface is steeper than that

struct Place {
  SurfaceSite site;
  std::string kind;
  double slope = 0.0;  // degrees
};

double slope_of(const Vector3& normal) {
  return std::acos(std::clamp(normal.y(), -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

std::string kind_of(const SurfaceSite& site, const std::vector<Vector3>& steep,
                    const std::vector<organ::Nodule>& nodules) {
  for (const auto& nodule : nodules) {
    const double aside = (site.place - nodule.centre).cross(site.normal).norm();
    if (aside < nodule.radius) return "above a nodule";
    if (aside < nodule.radius + kBeside) return "beside a nodule";
  }
  for (const Vector3& p : steep)
    if ((p - site.place).norm() < kRim) return "rim";
  return slope_of(site.normal) < kFlat ? "flat" : "slope";
}

// Kinds take turns, each place even over the area of its kind.
std::vector<Place> draw_places(const scene::TriangleMesh& surface, const std::vector<organ::Nodule>& nodules,
                               int count, std::uint64_t seed) {
  const auto distance = physics::tissue::SurfaceDistance::of(surface);
  std::vector<double> areas{0.0};
  std::vector<Vector3> steep;
  for (const auto& t : surface.triangles) {
    const Vector3 &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
    const Vector3 n = (b - a).cross(c - a);
    areas.push_back(areas.back() + n.norm());
    if (slope_of(n.normalized()) > kSteepest) steep.push_back((a + b + c) / 3.0);
  }
  constexpr std::array<const char*, 5> kKinds{"flat", "above a nodule", "slope", "beside a nodule", "rim"};
  Random random(seed, "bench/organ_places");
  std::vector<Place> places;
  for (int tries = 0; std::ssize(places) < count && tries < 1'000'000; ++tries) {
    const auto at =
        std::lower_bound(areas.begin() + 1, areas.end(), areas.back() * random.uniform()) - areas.begin() - 1;
    const auto& t = surface.triangles[static_cast<std::size_t>(at)];
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const Vector3 point =
        (1.0 - u - v) * surface.vertices[t[0]] + u * surface.vertices[t[1]] + v * surface.vertices[t[2]];
    const auto found = distance->at(point);
    const SurfaceSite site{found.foot, found.normal};
    const double slope = slope_of(site.normal);
    if (slope > kSteepest) continue;
    std::string kind = kind_of(site, steep, nodules);
    if (kind == kKinds[places.size() % kKinds.size()]) places.push_back({site, std::move(kind), slope});
  }
  return places;
}

std::set<int> done_in(const std::string& table) {
  std::set<int> done;
  std::ifstream file(table);
  for (std::string line; std::getline(file, line);)
    if (!line.empty() && line[0] >= '0' && line[0] <= '9') done.insert(std::atoi(line.c_str()));
  return done;
}

std::string line_of(int number, const Place& place, double depth, const organ::PreparedOrgan& soft,
                    const Expected<organ::FullPress>& full, std::size_t k, double took_s) {
  const auto& p = place.site.place;
  const Vector3& n = place.site.normal;
  const auto tick = soft.field.at(p + (soft.field.facts().tip_radius - depth) * n);
  std::string line =
      fmt::format("{},{},{:.1f},{:.3f},{:.3f},{:.3f},{:.1f},{:.5f}", number, place.kind, place.slope,
                  1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z(), 1e3 * depth, tick.force.norm());
  if (!full) return line + fmt::format(",,,,,{:.0f},\"{}\"\n", took_s, full.error().message);
  const auto& state = full->states[k];
  const double cosine = std::clamp(tick.force.normalized().dot(state.force.normalized()), -1.0, 1.0);
  return line + fmt::format(",{:.5f},{:.2f},{:.2f},{},{:.0f},\n", state.force.norm(),
                            100.0 * (tick.force.norm() / state.force.norm() - 1.0),
                            std::acos(cosine) * 180.0 / std::numbers::pi, full->nodes, took_s);
}

int run(const std::string& table, int count, std::uint64_t seed) {
  const auto surface = palpation::liver_mesh();
  palpation::NoduleRanges ranges;
  ranges.fewest = ranges.most = 3;
  const auto hidden = palpation::draw_nodules(surface, ranges, palpation::TrialRules{}.within,
                                              static_cast<std::int32_t>(seed));
  organ::OrganSettings settings;
  settings.tip_radius = 0.005;
  if (hidden)
    for (const auto& nodule : *hidden) settings.nodules.push_back(nodule.ball);
  const auto soft = hidden ? organ::prepare_organ(surface, settings) : tl::unexpected(hidden.error());
  if (!soft) {
    fmt::print(stderr, "organ_places: {}\n", soft.error().message);
    return 1;
  }
  const auto places = draw_places(surface, settings.nodules, count, seed);
  const auto done = done_in(table);
  std::ofstream file(table, std::ios::app);
  if (done.empty()) {
    for (const auto& nodule : settings.nodules)
      file << fmt::format("# nodule at {:.2f} {:.2f} {:.2f} mm, radius {:.2f} mm, {:.2f} times stiffer\n",
                          1e3 * nodule.centre.x(), 1e3 * nodule.centre.y(), 1e3 * nodule.centre.z(),
                          1e3 * nodule.radius, nodule.ratio);
    file << "place,kind,slope_deg,x_mm,y_mm,z_mm,depth_mm,tick_n,full_n,tick_beyond_full_percent,direction_"
            "deg,nodes,seconds,what\n";
  }
  for (int i = 0; i < std::ssize(places); ++i) {
    if (done.contains(i)) continue;
    const Place& place = places[static_cast<std::size_t>(i)];
    const auto begun = std::chrono::steady_clock::now();
    const auto full = organ::full_press(surface, settings, place.site, kDepths);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    std::string lines;
    for (std::size_t k = 0; k < kDepths.size(); ++k)
      lines += line_of(i, place, kDepths[k], *soft, full, k, took);
    fmt::print("{}", lines);
    std::fflush(stdout);
    file << lines << std::flush;
  }
  return file ? 0 : 1;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4 || argv[1][0] == '-') {
    fmt::print(stderr, "usage: organ_places TABLE [PLACES [SEED]]\n");
    return 2;
  }
  const int places = argc > 2 ? std::atoi(argv[2]) : 40;
  const auto seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  return palpate::run(argv[1], places, seed);
}
