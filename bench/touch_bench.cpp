// One tick of the proxy, beside one sweep of the same sphere over the same length by CollisionMesh, in the
// same run; and how often the proxy falls through or stays behind.
//
// Surface: 200 x 200 mm, z = A sin(2 pi x / 40 mm) cos(2 pi y / 50 mm), A = 5 mm (0 for the ripple). The tip,
// a sphere of 3 mm, is prescribed 2 mm under it, back and forth in x with a slow drift in y, a position every
// millisecond of its time; ticks run back to back. Below: the centre is nearer to the surface from above than
// half the radius, or under it. Stuck: proxy and tip more than 8 mm apart (5 mm are expected).
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/core/statistics.h"
#include "palpate/physics/height_field_for_tests.h"
#include "palpate/physics/proxy.h"

namespace palpate {
namespace {

constexpr double kRadius = 0.003, kDepth = 0.002;

double microseconds_since(std::chrono::steady_clock::time_point t) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - t).count();
}

bool below(const scene::TriangleMesh& surface, std::uint32_t cells, const Vector3& p) {
  return p.z() < physics::flat_height(surface, cells, p.x(), p.y()) + 0.5 * kRadius;
}

void slide(const scene::TriangleMesh& surface, const physics::CollisionMesh& mesh, std::uint32_t cells,
           double speed, double friction, int ticks) {
  const physics::Bumps bumps;
  physics::Proxy proxy(mesh, {.radius = kRadius, .friction = friction});
  proxy.begin({-0.08, -0.07, 0.02});
  std::vector<double> tick_us, sweep_us;
  int fallen = 0, stuck = 0, unsettled = 0;
  double sweeps = 0.0;
  Vector3 before = physics::tip_under(bumps, speed, kDepth, 0.0);
  for (int i = 0; i < ticks; ++i) {
    const Vector3 tip = physics::tip_under(bumps, speed, kDepth, i * 1e-3);
    const Vector3 from = proxy.state().position, to = from + (tip - before);
    before = tip;
    const auto sweep_begins = std::chrono::steady_clock::now();
    const auto hit = mesh.sweep(from, to, kRadius);
    const double one_sweep = microseconds_since(sweep_begins);
    if (hit && hit->fraction > 2.0) return;  // the compiler must not leave the sweep out
    const auto tick_begins = std::chrono::steady_clock::now();
    const physics::ProxyState& state = proxy.follow(tip);
    const double one_tick = microseconds_since(tick_begins);
    if (i > 0) {
      tick_us.push_back(one_tick);
      sweep_us.push_back(one_sweep);
    }
    fallen += below(surface, cells, state.position);
    stuck += (state.position - tip).norm() > 0.008;
    unsettled += !state.settled;
    sweeps += state.sweeps;
  }
  const double tick = quantile(tick_us, 0.5), sweep = quantile(sweep_us, 0.5);
  fmt::print(
      "{:>9} {:>6.1f} {:>8.1f}   {:>7.1f} {:>7.1f} {:>7.1f}   {:>7.1f} {:>7.1f}   {:>6.2f} {:>6.2f}   "
      "{:>5.1f} "
      "{:>7} {:>6} {:>9} of {}\n",
      surface.triangles.size(), speed, friction, tick, quantile(tick_us, 0.99), quantile(tick_us, 0.999),
      sweep, quantile(sweep_us, 0.99), tick / sweep, quantile(tick_us, 0.99) / quantile(sweep_us, 0.99),
      sweeps / ticks, fallen, stuck, unsettled, ticks);
}

void tap(const scene::TriangleMesh& surface, const physics::CollisionMesh& mesh, std::uint32_t cells,
         int taps) {
  Random random(1, "bench/taps");
  for (const double speed : {0.1, 1.0}) {
    for (int kind = 0; kind < 3; ++kind) {
      int fallen = 0, stuck = 0;
      for (int i = 0; i < taps; ++i) {
        Vector3 at;
        do {
          const auto& t = surface.triangles[random.below(surface.triangles.size())];
          const Vector3 &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
          at = kind == 0 ? a : kind == 1 ? Vector3(0.5 * (a + b)) : Vector3((a + b + c) / 3.0);
        } while (at.head<2>().lpNorm<Eigen::Infinity>() > 0.095);
        physics::Proxy proxy(mesh, {.radius = kRadius});
        double z = at.z() + 0.008 + 1e-3 * speed * random.uniform();
        proxy.begin({at.x(), at.y(), z});
        bool through = false;
        while (z > at.z() - kDepth) {
          z -= 1e-3 * speed;
          through = through || below(surface, cells, proxy.follow({at.x(), at.y(), z}).position);
        }
        fallen += through || !proxy.state().touching;
        stuck += proxy.state().depth > 0.008;
      }
      fmt::print("{:>9} {:>6.1f}   {:<8} fallen {} stuck {} of {}\n", surface.triangles.size(), speed,
                 std::array{"vertices", "edges", "faces"}[static_cast<std::size_t>(kind)], fallen, stuck,
                 taps);
    }
  }
}

void ripple(std::uint32_t cells) {
  const physics::Bumps flat{.amplitude = 0.0};
  const physics::CollisionMesh mesh(physics::height_field(flat, cells));
  for (const double speed : {0.01, 0.1, 1.0}) {
    physics::Proxy proxy(mesh, {.radius = kRadius});
    proxy.begin({-0.08, -0.07, 0.01});
    double least = 1e9, most = 0.0, sum = 0.0, aside = 0.0;
    constexpr int kTicks = 5000;
    for (int i = 0; i < kTicks; ++i) {
      const Vector3 tip = physics::tip_under(flat, speed, kDepth, i * 1e-3);
      const Vector3 push = proxy.follow(tip).position - tip;
      if (i == 0) continue;
      least = std::min(least, push.norm());
      most = std::max(most, push.norm());
      sum += push.norm();
      aside = std::max(aside, push.head<2>().norm());
    }
    const double mean = sum / (kTicks - 1);
    fmt::print("{:>9} {:>6.2f}   peak to peak {:.1e} %, sideways {:.1e} % of the mean\n", mesh.size(), speed,
               100.0 * (most - least) / mean, 100.0 * aside / mean);
  }
}

}  // namespace
}  // namespace palpate

int main() {
  using namespace palpate;
  fmt::print("sliding: us per tick, us per sweep, ratios\n");
  fmt::print(
      "triangles    m/s friction       p50     p99   p99.9     sweep     p99      p50    p99   sweeps  "
      "fallen  stuck unsettled\n");
  for (const std::uint32_t cells : {224u, 708u}) {
    const scene::TriangleMesh surface = physics::height_field({}, cells);
    const physics::CollisionMesh mesh(surface);
    for (const double speed : {0.1, 1.0})
      for (const double friction : {0.0, 0.3})
        slide(surface, mesh, cells, speed, friction, cells > 500 ? 10'000 : 20'000);
  }
  fmt::print("\ntaps, m/s\n");
  for (const std::uint32_t cells : {224u, 708u}) {
    const scene::TriangleMesh surface = physics::height_field({}, cells);
    const physics::CollisionMesh mesh(surface);
    tap(surface, mesh, cells, cells > 500 ? 300 : 1000);
  }
  fmt::print("\nripple of the force on a plane without friction, m/s\n");
  ripple(224);
  return 0;
}
