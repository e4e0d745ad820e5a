// The tick on a liver-like organ beside the full neo-Hookean solution on a mesh that is refined under the tip: at random
// places of the upper side, above and beside nodules, on slopes up to 30 degrees and near the rim, three depths each.
//
// usage: organ_places TABLE [PLACES [SEED]]
// TABLE: CSV, a line for each place and depth. Full solutions that are in it are not computed again, so hours of computing
// may be interrupted, and the tick's columns are those of this program whenever it runs. scripts/organ-places builds, runs
// and draws it. A place without equilibrium is said in its line (`what`), not left out.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "applications/palpation/liver.h"
#include "applications/palpation/nodules.h"
#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "palpate/physics/organ/full_press.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate {
namespace {

namespace organ = physics::organ;
namespace palpation = applications::palpation;
using physics::deformable::SurfaceSite;

const std::vector<double> kDepths{0.0015, 0.003, 0.0045};  // m
constexpr const char* kUnits = "tick and full neo-Hookean solution; frame of the liver, y up; tip of 5 mm\n";
constexpr double kSteepest = 30.0, kFlat = 10.0;  // degrees
constexpr double kBeside = 0.010;                 // m, from a nodule's rim, seen from above
constexpr double kRim = 0.015;                    // m, to where the surface is steeper than that

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

// What the table has of one state: the full solution's force, which takes long, or why there is none.
struct Known {
  Vector3 force = Vector3::Zero();
  std::string nodes, seconds, what;
  bool there() const { return what.empty(); }
};
using Table = std::map<std::pair<int, int>, Known>;  // by place and depth, micrometres

int micrometres(double depth) { return static_cast<int>(std::lround(1e6 * depth)); }

constexpr const char* kColumns =
    "place,kind,slope_deg,x_mm,y_mm,z_mm,depth_mm,tick_n,full_x_n,full_y_n,full_z_n,tick_beyond_full_percent,"
    "direction_deg,nodes,seconds,what";

Table read_table(const std::string& name) {
  Table table;
  std::ifstream file(name);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] < '0' || line[0] > '9') continue;
    std::vector<std::string> cells;
    std::istringstream cut(line);
    for (std::string cell; std::getline(cut, cell, ',');) cells.push_back(cell);
    cells.resize(16);
    const auto number = [&](std::size_t k) { return std::strtod(cells[k].c_str(), nullptr); };
    table[{std::atoi(cells[0].c_str()), micrometres(1e-3 * number(6))}] = {
        {number(8), number(9), number(10)}, cells[13], cells[14], cells[15]};
  }
  return table;
}

// The organ from above: of each direction from the middle the vertex furthest out.
std::string outline_of(const scene::TriangleMesh& surface) {
  constexpr int kDirections = 90;
  Vector3 middle = Vector3::Zero();
  for (const Vector3& v : surface.vertices) middle += v / static_cast<double>(surface.vertices.size());
  std::array<Vector3, kDirections> furthest;
  furthest.fill(Vector3::Zero());
  for (const Vector3& v : surface.vertices) {
    const Vector3 out = v - middle;
    const double share = 0.5 + std::atan2(out.z(), out.x()) / (2.0 * std::numbers::pi);
    Vector3& known = furthest[static_cast<std::size_t>(share * kDirections) % kDirections];
    if (std::hypot(out.x(), out.z()) > std::hypot(known.x(), known.z())) known = out;
  }
  std::string line = "# outline";
  for (const Vector3& out : furthest)
    if (!out.isZero(0.0))
      line += fmt::format(" {:.1f} {:.1f}", 1e3 * (middle.x() + out.x()), 1e3 * (middle.z() + out.z()));
  return line + "\n";
}

std::string line_of(int number, const Place& place, double depth, const organ::PreparedOrgan& soft,
                    const Known& full) {
  const auto& p = place.site.place;
  const Vector3 tick = soft.field.at(p + (soft.field.facts().tip_radius - depth) * place.site.normal).force;
  std::string line =
      fmt::format("{},{},{:.1f},{:.3f},{:.3f},{:.3f},{:.1f},{:.5f}", number, place.kind, place.slope,
                  1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z(), 1e3 * depth, tick.norm());
  if (!full.there()) return line + fmt::format(",,,,,,{},{},{}\n", full.nodes, full.seconds, full.what);
  const double cosine = std::clamp(tick.normalized().dot(full.force.normalized()), -1.0, 1.0);
  return line + fmt::format(",{:.5f},{:.5f},{:.5f},{:.2f},{:.2f},{},{},\n", full.force.x(), full.force.y(),
                            full.force.z(), 100.0 * (tick.norm() / full.force.norm() - 1.0),
                            std::acos(cosine) * 180.0 / std::numbers::pi, full.nodes, full.seconds);
}

void compute(const scene::TriangleMesh& surface, const organ::OrganSettings& settings, int number,
             const Place& place, Table& table) {
  const auto begun = std::chrono::steady_clock::now();
  const auto full = organ::full_press(surface, settings, place.site, kDepths);
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  for (std::size_t k = 0; k < kDepths.size(); ++k) {
    Known& state = table[{number, micrometres(kDepths[k])}];
    state.seconds = fmt::format("{:.0f}", took);
    if (full) {
      state.force = full->states[k].force;
      state.nodes = fmt::format("{}", full->nodes);
    } else {
      state.what = full.error().message;
      std::replace(state.what.begin(), state.what.end(), ',', ';');
    }
  }
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
  std::string text = "# " + std::string(kUnits);
  for (const auto& nodule : settings.nodules)
    text += fmt::format("# nodule at {:.2f} {:.2f} {:.2f} mm, radius {:.2f} mm, {:.2f} times stiffer\n",
                        1e3 * nodule.centre.x(), 1e3 * nodule.centre.y(), 1e3 * nodule.centre.z(),
                        1e3 * nodule.radius, nodule.ratio);
  text += outline_of(surface) + std::string(kColumns) + "\n";
  Table known = read_table(table);
  for (int i = 0; i < std::ssize(places); ++i) {
    const Place& place = places[static_cast<std::size_t>(i)];
    if (!known.contains({i, micrometres(kDepths.front())})) compute(surface, settings, i, place, known);
    std::string lines;
    for (const double depth : kDepths)
      lines += line_of(i, place, depth, *soft, known[{i, micrometres(depth)}]);
    fmt::print("{}", lines);
    std::fflush(stdout);
    text += lines;
    // Of places that are known and not reached yet the table keeps what it has.
    std::string rest;
    for (int later = i + 1; later < std::ssize(places); ++later)
      for (const double depth : kDepths)
        if (const auto found = known.find({later, micrometres(depth)}); found != known.end())
          rest += line_of(later, places[static_cast<std::size_t>(later)], depth, *soft, found->second);
    if (const auto written = write_file(table, text + rest); !written) {
      fmt::print(stderr, "organ_places: {}\n", written.error().message);
      return 1;
    }
  }
  return 0;
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
