// Ours, Bullet and MuJoCo side by side on the same scene (bench/physics_rivals.h), and sweeps beside Bullet
// and rays beside Embree: one process, rounds that alternate, each contender also against itself to show the
// noise. Times are per call, with the timer's own cost (measured in the same run) taken off.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <vector>

#include "applications/pingpong/ball_world.h"
#include "bench/physics_rivals.h"
#include "palpate/core/random.h"
#include "palpate/core/statistics.h"
#include "palpate/physics/height_field_for_tests.h"

namespace palpate::bench {
namespace {

constexpr int kRounds = 11;

double now_ns() {
  return static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                 std::chrono::steady_clock::now().time_since_epoch())
                                 .count());
}

double timer_ns() {
  std::vector<double> all;
  for (int i = 0; i < 20000; ++i) {
    const double begun = now_ns();
    all.push_back(now_ns() - begun);
  }
  return quantile(all, 0.5);
}

// The game's own step where the surfaces are rectangles; for boxes the same with meshes of boxes.
class Ours : public Engine {
 public:
  explicit Ours(const Setting& setting) : dt_(setting.dt), world_(scene(setting), game()) {}
  void place(const Vector3& position, const Vector3& velocity) override {
    world_.place({position, velocity, Vector3::Zero()});
  }
  void step(const BatPlace& before, const BatPlace& after) override {
    applications::pingpong::BatMotion bat;
    bat.before = {before.rotation, before.centre};
    bat.after = {after.rotation, after.centre};
    bat.velocity = (after.centre - before.centre) / dt_;
    bat.angular_velocity = 2.0 / dt_ * (after.rotation * before.rotation.conjugate()).vec();
    world_.step(dt_, bat);
  }
  Vector3 position() const override { return world_.ball().position; }
  Vector3 velocity() const override { return world_.ball().velocity; }

 private:
  static scene::SceneDescription scene(const Setting& setting) {
    scene::SceneDescription scene;
    const Vector3 a(-0.375, 0, 0), b(0.375, 0, 0), front(0, 0, 1.0), up(0, 0.6, 0);
    scene.surfaces = {{"table", {Vector3(a + front), Vector3(b + front), b, a}},
                      {"wall", {a, b, Vector3(b + up), Vector3(a + up)}}};
    if (!setting.gravity) scene.gravity.setZero();
    return scene;
  }
  static applications::pingpong::GameSettings game() {
    return {.surface_restitution = kRestitution,
            .bat_restitution = kRestitution,
            .contact_s = kContact,
            .flight = applications::pingpong::Flight::paper};
  }
  double dt_;
  applications::pingpong::BallWorld world_;
};

class OursOnBoxes : public Engine {
 public:
  explicit OursOnBoxes(const Setting& setting) : dt_(setting.dt) {
    auto mesh = scene::box_mesh({-0.375, -kThick, 0}, {0.375, 0, 1.0});
    scene::append(mesh, scene::box_mesh({-0.375, 0, -kThick}, {0.375, 0.6, 0}));
    mesh_ = physics::CollisionMesh(mesh);
    if (!setting.gravity) model_.gravity.setZero();
  }
  void place(const Vector3& position, const Vector3& velocity) override {
    ball_ = {position, velocity, Vector3::Zero()};
  }
  void step(const BatPlace&, const BatPlace&) override {
    double left = dt_;
    for (int event = 0; event < 12 && left > 0.0; ++event) {
      const physics::BallState next = physics::fly(model_, ball_, left);
      const auto hit = mesh_.sweep(ball_.position, next.position, kRadius);
      if (!hit) {
        ball_ = next;
        return;
      }
      const Vector3 touch = ball_.position + hit->fraction * (next.position - ball_.position);
      ball_ = physics::fly(model_, ball_, hit->fraction * left);
      ball_.position = touch;
      ball_ = physics::bounce(model_, ball_, hit->normal, {kRestitution, 0.0});
      left *= 1.0 - hit->fraction;
    }
  }
  Vector3 position() const override { return ball_.position; }
  Vector3 velocity() const override { return ball_.velocity; }

 private:
  double dt_;
  physics::BallModel model_ = physics::BallModel::paper();
  physics::BallState ball_;
  physics::CollisionMesh mesh_;
};

std::unique_ptr<Engine> make_ours(const Setting& setting) {
  if (setting.surfaces == Surfaces::box) return std::make_unique<OursOnBoxes>(setting);
  return std::make_unique<Ours>(setting);
}

using Maker = std::function<std::unique_ptr<Engine>(const Setting&)>;
struct Named {
  const char* name;
  Maker make;
};
const std::vector<Named> kEngines = {{"ours", make_ours}, {"Bullet", make_bullet}, {"MuJoCo", make_mujoco}};

// A hand that drives the ball back over the table again and again.
BatPlace bat_at(double t) {
  return {{0.05 * std::sin(3.0 * t), 0.18 + 0.05 * std::sin(5.0 * t), 0.85 + 0.10 * std::sin(12.0 * t)},
          so3_exp(Vector3(-1.4 + 0.2 * std::sin(7.0 * t), 0.1 * std::sin(4.0 * t), 0.0))};
}

struct Serve {
  Vector3 position, velocity;
};
std::vector<Serve> serves() {
  Random random(1, "bench/physics/serve");
  std::vector<Serve> all;
  for (int i = 0; i < 40; ++i)
    all.push_back({{random.uniform(-0.1, 0.1), random.uniform(0.15, 0.3), random.uniform(0.4, 0.6)},
                   {random.uniform(-0.3, 0.3), random.uniform(-1.0, 1.0), random.uniform(-6.0, -2.0)}});
  return all;
}

// Times of single steps, ns; every serve is played for 0.4 s.
std::vector<double> play(Engine& engine, double dt, double timer, double& total) {
  std::vector<double> times;
  const auto count = static_cast<int>(std::lround(0.4 / dt));
  std::vector<BatPlace> bat;
  for (int i = 0; i <= count; ++i) bat.push_back(bat_at(i * dt));
  const auto all = serves();
  times.reserve(all.size() * bat.size());
  total = 0.0;
  for (std::size_t s = 0; s < all.size(); ++s) {
    engine.place(all[s].position, all[s].velocity);
    const bool each = s % 2 == 0;  // one serve step by step, the next as a whole without the timer
    const double begun = now_ns();
    for (std::size_t i = 0; i + 1 < bat.size(); ++i) {
      if (!each) {
        engine.step(bat[i], bat[i + 1]);
        continue;
      }
      const double step_begun = now_ns();
      engine.step(bat[i], bat[i + 1]);
      times.push_back(now_ns() - step_begun - timer);
    }
    if (!each) total += now_ns() - begun;
  }
  total /= 0.5 * static_cast<double>(all.size()) * static_cast<double>(count);
  return times;
}

void steps() {
  const double timer = timer_ns();
  fmt::print(
      "\nOne step of ball, table, wall and moving bat, ns (timer of {:.0f} ns taken off p50 and p99)\n",
      timer);
  fmt::print("{:8} {:>10} {:>8} {:>8} {:>8} {:>14} {:>16}\n", "dt ms", "engine", "mean", "p50", "p99",
             "ours / it", "least - most");
  for (const double dt : {0.001, 0.0001}) {
    std::vector<std::unique_ptr<Engine>> engines;
    std::vector<const char*> names;
    for (const auto& named : kEngines) {
      if (auto engine = named.make({dt, Surfaces::mesh, true})) {
        engines.push_back(std::move(engine));
        names.push_back(named.name);
      }
    }
    engines.push_back(make_ours({dt, Surfaces::mesh, true}));
    names.push_back("ours again");
    std::vector<std::vector<double>> means(engines.size()), all(engines.size());
    for (int round = -1; round < kRounds; ++round) {
      for (std::size_t i = 0; i < engines.size(); ++i) {
        double mean = 0.0;
        const auto times = play(*engines[i], dt, timer, mean);
        if (round < 0) continue;  // warms up
        means[i].push_back(mean);
        all[i].insert(all[i].end(), times.begin(), times.end());
      }
    }
    for (std::size_t i = 0; i < engines.size(); ++i) {
      std::vector<double> ratios;
      for (std::size_t r = 0; r < means[i].size(); ++r) ratios.push_back(means[0][r] / means[i][r]);
      fmt::print("{:<8} {:>10} {:8.0f} {:8.0f} {:8.0f} {:14.3f} {:8.3f} - {:.3f}\n", 1e3 * dt, names[i],
                 quantile(means[i], 0.5), quantile(all[i], 0.5), quantile(all[i], 0.99),
                 quantile(ratios, 0.5), quantile(ratios, 0.0), quantile(ratios, 1.0));
    }
  }
}

void restitution() {
  fmt::print(
      "\nRestitution, {} asked, straight down, 20 phases, no gravity: mean, largest error; lost = through or "
      "stuck\n",
      kRestitution);
  fmt::print("{:8} {:6} {:>8}", "engine", "on", "dt ms");
  for (const int speed : {3, 10, 20, 30, 100}) fmt::print(" {:>24}", fmt::format("{} m/s", speed));
  fmt::print("\n");
  for (const auto surfaces : {Surfaces::mesh, Surfaces::box}) {
    for (const double dt : {0.001, 0.0001}) {
      for (const auto& named : kEngines) {
        const auto engine = named.make({dt, surfaces, false});
        if (!engine) continue;
        const bool plane = surfaces == Surfaces::mesh && named.name[0] == 'M';
        fmt::print("{:8} {:6} {:8}", named.name,
                   plane                        ? "plane"
                   : surfaces == Surfaces::mesh ? "mesh"
                                                : "box",
                   1e3 * dt);
        for (const double speed : {3.0, 10.0, 20.0, 30.0, 100.0}) {
          double sum = 0.0, worst = 0.0;
          int lost = 0, good = 0;
          for (int phase = 0; phase < 20; ++phase) {
            const double height = kRadius + 0.3 + speed * dt * (phase + 0.37) / 20.0;
            engine->place({0.03, height, 0.45}, {0, -speed, 0});
            const BatPlace away{{0, 9, 0}, Quaternion::Identity()};
            const auto count = static_cast<int>((0.6 / speed + 0.02) / dt);
            for (int i = 0; i < count; ++i) engine->step(away, away);
            const double out = engine->velocity().y() / speed;
            // Through it, or out of it with less than half of what it should have.
            if (engine->position().y() < 0.5 * kRadius || out < 0.5 * kRestitution) {
              ++lost;
              continue;
            }
            ++good;
            sum += out;
            worst = std::max(worst, std::abs(out - kRestitution));
          }
          fmt::print(" {:>24}", good == 0 ? fmt::format("lost {}/20", lost)
                                          : fmt::format("{:.3f} {:7.1e} lost {:2}", sum / good, worst, lost));
        }
        fmt::print("\n");
      }
    }
  }
}

scene::TriangleMesh bumpy(std::uint32_t side) {
  Random random(2, "bench/physics/field");
  const double bump = side == 1 ? 0.0 : 0.010 * std::min(1.0, 22.0 / side);  // slopes of the same steepness
  return physics::rough_field(side, bump, random);
}

class OurSweep : public Sweeper {
 public:
  explicit OurSweep(const physics::CollisionMesh& mesh) : mesh_(mesh) {}
  std::optional<double> first(const Vector3& from, const Vector3& to) override {
    const auto hit = mesh_.sweep(from, to, kRadius);
    return hit ? std::optional(hit->fraction) : std::nullopt;
  }

 private:
  const physics::CollisionMesh& mesh_;
};
class OurRay : public Sweeper {
 public:
  explicit OurRay(const physics::CollisionMesh& mesh) : mesh_(mesh) {}
  std::optional<double> first(const Vector3& from, const Vector3& to) override {
    const auto hit = mesh_.ray(from, to);
    return hit ? std::optional(hit->fraction) : std::nullopt;
  }

 private:
  const physics::CollisionMesh& mesh_;
};

struct Contender {
  const char* name;
  std::unique_ptr<Sweeper> sweeper;
  const std::vector<std::pair<Vector3, Vector3>>* paths;
  std::size_t beside;  // whom it is compared with
  std::vector<double> means, times;
  std::vector<std::optional<double>> answers;
};

void print_beside(const Contender& c, const Contender& ours, std::size_t triangles) {
  std::vector<double> ratios, off;
  int hits = 0, disagree = 0;
  for (std::size_t r = 0; r < c.means.size(); ++r) ratios.push_back(ours.means[r] / c.means[r]);
  for (std::size_t i = 0; i < c.answers.size(); ++i) {
    hits += c.answers[i].has_value();
    disagree += c.answers[i].has_value() != ours.answers[i].has_value();
    if (c.answers[i] && ours.answers[i]) {
      const auto& [from, to] = (*c.paths)[i];
      off.push_back(1e3 * (to - from).norm() * std::abs(*c.answers[i] - *ours.answers[i]));
    }
  }
  fmt::print("{:>9} {:20} {:9.3f} {:9.3f} {:9.3f} {:6.0f}% {:12.3f} {:8.3f} - {:.3f}", triangles, c.name,
             quantile(c.means, 0.5), quantile(c.times, 0.5), quantile(c.times, 0.99),
             100.0 * hits / static_cast<double>(c.answers.size()), quantile(ratios, 0.5),
             quantile(ratios, 0.0), quantile(ratios, 1.0));
  if (&c != &ours)
    fmt::print("  {:.2f} % differ, p99 {:.2g} mm off",
               100.0 * disagree / static_cast<double>(c.answers.size()), quantile(off, 0.99));
  fmt::print("\n");
}

void sweeps() {
  const double timer = timer_ns();
  fmt::print(
      "\nSphere of 20 mm going 10 mm in any direction, near a bumpy field of 2 x 2 m; rays the same way, 60 "
      "mm. "
      "us, timer taken off\n");
  fmt::print("{:>9} {:20} {:>9} {:>9} {:>9} {:>7} {:>12} {:>16} {:>26}\n", "triangles", "what", "mean", "p50",
             "p99", "hits", "ours / it", "least - most", "beside ours");
  for (const std::uint32_t side : {1u, 22u, 224u, 707u}) {
    const auto mesh = bumpy(side);
    const double begun = now_ns();
    const physics::CollisionMesh prepared(mesh);
    const double built_ms = 1e-6 * (now_ns() - begun);
    Random random(3, "bench/physics/path");
    std::vector<std::pair<Vector3, Vector3>> paths, rays;
    while (paths.size() < 2000) {
      const Vector3 from(random.uniform(-0.9, 0.9), random.uniform(0.021, 0.036), random.uniform(-0.9, 0.9));
      Vector3 u(random.normal(), random.normal(), random.normal());
      u.normalize();
      const auto hit = prepared.sweep(from, from + 0.010 * u, kRadius);
      if (hit && hit->fraction == 0.0) continue;  // overlaps at the start: another question
      paths.emplace_back(from, from + 0.010 * u);
      rays.emplace_back(from, from + 0.060 * u);
    }
    std::vector<Contender> all;
    const auto add = [&](const char* name, std::unique_ptr<Sweeper> sweeper, const auto& of,
                         std::size_t beside) {
      if (sweeper) all.push_back({name, std::move(sweeper), &of, beside, {}, {}, {}});
    };
    add("our sweep", std::make_unique<OurSweep>(prepared), paths, 0);
    add("our sweep again", std::make_unique<OurSweep>(prepared), paths, 0);
    add("Bullet convexSweep", make_bullet_sweeper(mesh), paths, 0);
    const std::size_t ray = all.size();
    add("our ray", std::make_unique<OurRay>(prepared), rays, ray);
    add("Embree ray (float)", make_embree_ray(mesh), rays, ray);
    for (int round = -1; round < kRounds; ++round) {
      for (auto& c : all) {
        double total = 0.0;
        for (std::size_t i = 0; i < c.paths->size(); ++i) {
          const auto& [from, to] = (*c.paths)[i];
          const double start = now_ns();
          const auto answer = c.sweeper->first(from, to);
          const double took = now_ns() - start - timer;
          total += took;
          if (round < 0) c.answers.push_back(answer);
          if (round >= 0) c.times.push_back(1e-3 * took);
        }
        if (round >= 0) c.means.push_back(1e-3 * total / static_cast<double>(c.paths->size()));
      }
    }
    for (const auto& c : all) {
      print_beside(c, all[c.beside], mesh.triangles.size());
    }
    fmt::print("{:>9} built in {:.0f} ms\n", "", built_ms);
  }
}

}  // namespace
}  // namespace palpate::bench

int main() {
  using namespace palpate::bench;
  for (const auto& [name, there] :
       {std::pair{"Bullet", make_bullet({}) != nullptr}, {"MuJoCo", make_mujoco({}) != nullptr}})
    if (!there) fmt::print("{} was not found when this was configured: its rows are missing\n", name);
  steps();
  restitution();
  sweeps();
  return 0;
}
