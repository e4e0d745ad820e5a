// One tick of the tissue law on a body of more than 10,000 surface vertices, beside one tick of touch's proxy on the
// same surface along the same path, in the same run; and what preparing the field takes.
//
// Body: a ball of 50 mm whose radius varies by 2 mm, 700 sites, lattice of 2 mm, a stiffer place. The tip, a sphere
// of 5 mm, slides over it, 1 to 5 mm deep, a position every millisecond of its time; ticks run back to back, in
// rounds that alternate. Wherever: the same law at places drawn at random, so that no line of the lattice is in the
// cache.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/core/statistics.h"
#include "palpate/math/random_vector.h"
#include "palpate/physics/proxy.h"
#include "palpate/physics/tissue/tissue_for_tests.h"
#include "palpate/physics/tissue/tissue_law.h"

namespace palpate {
namespace {

namespace tissue = physics::tissue;

constexpr double kBall = 0.05, kTip = 0.005, kDeepest = 0.006;
constexpr int kTicks = 50'000, kRounds = 4;

double radius_towards(const Vector3& n) {
  return kBall + 0.002 * std::sin(5.0 * n.x()) * std::cos(4.0 * n.y() + 1.0);
}

scene::TriangleMesh bumpy_ball() {
  scene::TriangleMesh mesh = scene::sphere_mesh(1.0, 80, 160);
  for (Vector3& v : mesh.vertices) v = radius_towards(v.normalized()) * v.normalized();
  mesh.version.raise();
  return mesh;
}

std::vector<tissue::EnergySite> sites_of(const tissue::SoftForTests& soft) {
  std::vector<tissue::EnergySite> sites;
  constexpr int kSites = 700;
  for (int i = 0; i < kSites; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kSites, turn = 2.399963 * i, r = std::sqrt(1.0 - z * z);
    const Vector3 n(r * std::cos(turn), r * std::sin(turn), z);
    sites.push_back(soft.site(radius_towards(n) * n, n, kDeepest));
  }
  return sites;
}

Vector3 tip_at(double seconds) {
  const double up = 0.9 * std::sin(0.7 * seconds), around = 1.3 * seconds;
  const Vector3 n(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
  return (radius_towards(n) + kTip - 0.003 - 0.002 * std::sin(9.0 * seconds)) * n;
}

double microseconds_since(std::chrono::steady_clock::time_point t) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - t).count();
}

template <typename Tick>
void time_ticks(std::vector<double>& took, Tick&& tick) {
  for (int i = 0; i < kTicks; ++i) {
    const auto begins = std::chrono::steady_clock::now();
    tick(i);
    took.push_back(microseconds_since(begins));
  }
}

void print(const char* what, const std::vector<double>& took) {
  fmt::print("{:<34} {:>8.2f} {:>8.2f} {:>8.2f} {:>9.1f}\n", what, quantile(took, 0.5), quantile(took, 0.99),
             quantile(took, 0.999), quantile(took, 1.0));
}

int run() {
  const scene::TriangleMesh surface = bumpy_ball();
  const tissue::SoftForTests soft{.radius = kTip, .share = tissue::bump_for_tests({kBall, 0, 0}, 0.4, 0.01)};
  const auto begins = std::chrono::steady_clock::now();
  const auto field = tissue::TipField::build(surface, sites_of(soft), {.tip_radius = kTip});
  if (!field) {
    fmt::print("{}\n", field.error().message);
    return 1;
  }
  const auto& lattice = field->fields().lattice();
  fmt::print(
      "{} vertices; lattice {} x {} x {}, {:.1f} MB, built in {:.2f} s; {:.0f} N/m where it is stiffest\n",
      surface.vertices.size(), lattice.count[0], lattice.count[1], lattice.count[2],
      1e-6 * static_cast<double>(field->fields().coefficients().size() * sizeof(float)),
      1e-6 * microseconds_since(begins), field->facts().stiffest_n_m);

  tissue::TissueLaw law(*field, {.dissipation = {.friction = 0.3}}, {});
  const physics::CollisionMesh mesh(surface);
  physics::Proxy proxy(mesh, {.radius = kTip, .friction = 0.3});
  Random random(1, "bench/tissue");
  std::vector<double> law_us, field_us, proxy_us;
  Vector3 sum = Vector3::Zero();
  scene::TipState tip;
  tip.X_world_tip.translation = 1.5 * tip_at(0.0);
  law.force(tip, 1e-3);
  proxy.begin(tip.X_world_tip.translation);
  for (int round = 0; round < kRounds; ++round) {
    const int first = round * kTicks;
    // In steps that no contact takes for a leap.
    for (int i = 0; i <= 100; ++i) {
      tip.X_world_tip.translation = (1.5 - 0.005 * i) * tip_at(1e-3 * first);
      law.force(tip, 1e-3);
      proxy.follow(tip.X_world_tip.translation);
    }
    time_ticks(law_us, [&](int i) {
      tip.X_world_tip.translation = tip_at(1e-3 * (first + i));
      sum += law.force(tip, 1e-3);
    });
    if (law.newest().contact.depth <= 0.0) {
      fmt::print("the tip has lost the body\n");
      return 1;
    }
    time_ticks(proxy_us, [&](int i) { sum += proxy.follow(tip_at(1e-3 * (first + i))).position; });
    time_ticks(field_us, [&](int) {
      sum += field->at((kBall + kTip * random.uniform()) * uniform3(random, 1.0).normalized()).force;
    });
    for (int i = 0; i <= 100; ++i) {
      tip.X_world_tip.translation = (1.0 + 0.005 * i) * tip_at(1e-3 * (first + kTicks));
      law.force(tip, 1e-3);
      proxy.follow(tip.X_world_tip.translation);
    }
  }
  fmt::print("us a tick, clock included               p50      p99    p99.9   largest\n");
  print("tissue law, sliding", law_us);
  print("its field alone, wherever", field_us);
  print("touch's proxy, sliding", proxy_us);
  return std::isfinite(sum.norm()) ? 0 : 1;
}

}  // namespace
}  // namespace palpate

int main() { return palpate::run(); }
