// What it takes to make a liver-like organ ready: with one nodule and with three, of a known organ, from the cache; and
// one shape for the picture beside as many vertices copied. Wall and processor time, of this run.
//
// usage: organ_bench [FOLDER]     an empty one for the cache, kept (default: a new one in /tmp, removed)
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "applications/palpation/liver.h"
#include "palpate/core/statistics.h"
#include "palpate/physics/organ/prepared_organ.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate {
namespace {

namespace organ = physics::organ;
namespace fs = std::filesystem;

constexpr int kShapes = 400;

double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Within the liver's thick part, apart from each other.
std::vector<organ::Nodule> nodules(int count, double shift) {
  std::vector<organ::Nodule> all;
  for (int k = 0; k < count; ++k) all.push_back({{0.03 - 0.03 * k + shift, 0.02, 0.01 * k}, 0.0075, 10.0});
  return all;
}

bool prepare(const char* what, const scene::TriangleMesh& surface, const fs::path& cache,
             std::vector<organ::Nodule> hidden) {
  organ::OrganSettings settings;
  settings.cache = cache;
  settings.nodules = std::move(hidden);
  const double wall = seconds_of(CLOCK_MONOTONIC), cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  std::string parts, before;
  double begun = wall;
  const auto made = organ::prepare_organ(surface, settings, [&](std::string_view name, double) {
    if (name == before) return true;
    const double now = seconds_of(CLOCK_MONOTONIC);
    if (!before.empty()) parts += fmt::format("  {} {:.1f}", before, now - begun);
    before = name, begun = now;
    return true;
  });
  if (!made) {
    fmt::print("{}: {}\n", what, made.error().message);
    return false;
  }
  fmt::print("{:<38} {:>6.2f} s, processor {:>6.2f} s:{}\n", what, seconds_of(CLOCK_MONOTONIC) - wall,
             seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu, parts);
  return true;
}

bool time_shapes(const scene::TriangleMesh& surface, const fs::path& cache) {
  organ::OrganSettings settings;
  settings.cache = cache;
  settings.nodules = nodules(1, 0.0);
  const auto made = organ::prepare_organ(surface, settings);
  if (!made) return false;
  const auto distance = physics::tissue::SurfaceDistance::of(surface);
  std::vector<Vector3> shape(surface.vertices.size());
  std::vector<double> dents_us, copies_us;
  for (int i = 0; i < kShapes; ++i) {
    const auto foot = distance->at({0.05 * std::cos(0.1 * i), 0.1, 0.03 * std::sin(0.13 * i)});
    const Vector3 tip = foot.foot + (settings.tip_radius - 0.004) * foot.normal;
    const auto tick = made->field.at(tip);
    double begun = seconds_of(CLOCK_MONOTONIC);
    made->dent.press(tip, tick.depth, tick.force, shape);
    dents_us.push_back(1e6 * (seconds_of(CLOCK_MONOTONIC) - begun));
    begun = seconds_of(CLOCK_MONOTONIC);
    std::copy(surface.vertices.begin(), surface.vertices.end(), shape.begin());
    copies_us.push_back(1e6 * (seconds_of(CLOCK_MONOTONIC) - begun));
  }
  fmt::print(
      "shape for the picture, us: p50 {:.0f}, p90 {:.0f}, p99 {:.0f}; its vertices copied: p50 {:.0f}\n",
      quantile(dents_us, 0.5), quantile(dents_us, 0.9), quantile(dents_us, 0.99), quantile(copies_us, 0.5));
  return true;
}

int run(const fs::path& cache) {
  const auto surface = applications::palpation::liver_mesh();
  fmt::print("{} vertices, {:.0f} cm3\n", surface.vertices.size(),
             1e6 * applications::palpation::volume_of(surface));
  const bool good = prepare("one nodule, nothing known", surface, cache, nodules(1, 0.0)) &&
                    prepare("the same from the cache", surface, cache, nodules(1, 0.0)) &&
                    prepare("three new nodules, organ known", surface, cache, nodules(3, 0.0)) &&
                    prepare("one new nodule, organ known", surface, cache, nodules(1, 0.004)) &&
                    prepare("three nodules, nothing known", surface, {}, nodules(3, 0.0)) &&
                    time_shapes(surface, cache);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  const fs::path folder =
      argc > 1 ? fs::path(argv[1]) : fs::temp_directory_path() / fmt::format("organ-bench-{}", getpid());
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  const int result = palpate::run(folder);
  if (argc <= 1) fs::remove_all(folder, ignored);
  return result;
}
