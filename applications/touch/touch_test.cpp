#include "applications/touch/touch.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <numbers>
#include <string>

#include "applications/touch/looks.h"
#include "applications/touch/organ_for_tests.h"
#include "applications/touch/scene_view.h"
#include "tests/allocation_count.h"

namespace palpate::applications::touch {
namespace {

scene::SceneDescription coarse_for_tests(double static_friction = 0.4, double friction = 0.3) {
  // In this order: friction above static friction is refused on the way, too.
  return with(with(organ_on_table(), "touch.friction", friction), "touch.static_friction", static_friction);
}

constexpr double kTick = 1e-3;

struct Bench {
  explicit Bench(const Settings& settings = {}, const scene::SceneDescription& scene = table_for_tests())
      : touch(scene, settings) {
    double highest = 0.0;  // above the middle
    for (const auto& v : touch.surface().vertices)
      if (std::abs(v.x()) < 0.002 && std::abs(v.z()) < 0.002) highest = std::max(highest, v.y());
    top = touch.rest().translation + highest * Vector3::UnitY();
    tip.X_world_tip.translation = top + Vector3(0, 0.02, 0);
  }
  void step() {
    now += seconds(kTick);
    tip.time = now;
    touch.contact_law()->force(tip, kTick);  // as the haptic tick does
    touch.step(now, seconds(kTick), tip, state);
    state.time = now;
  }
  void go_to(const Vector3& place, double speed) {
    while ((place - at()).norm() > 1e-9) {
      const Vector3 way = place - at();
      const double step_m = std::min(way.norm(), speed * kTick);
      tip.velocity = step_m / kTick * way.normalized();
      tip.X_world_tip.translation += step_m * way.normalized();
      step();
    }
    tip.velocity.setZero();
  }
  const Vector3& at() const { return tip.X_world_tip.translation; }
  Vector3 force() const { return Vector3(state.continuous.force.data()); }
  TouchApplication touch;
  scene::TipState tip;
  scene::SceneState state;
  Instant<PhysicsClock> now = Instant<PhysicsClock>::from_seconds(50.0);
  Vector3 top;
};

TEST(Organ, IsClosedAndAHundredThousandTrianglesThatLookOutwards) {
  const scene::TriangleMesh mesh = organ_mesh();
  EXPECT_EQ(mesh.triangles.size(), 100'352u);
  EXPECT_EQ(mesh.vertices.size(), mesh.triangles.size() / 2 + 2) << "Euler's formula of a sphere";
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    ASSERT_GT((b - a).cross(c - a).dot(a + b + c), 0.0);
  }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_EQ((edges.count({edge.second, edge.first})), 1u);
  }
  EXPECT_THROW(organ_mesh(1), std::invalid_argument);
}

TEST(TouchApplication, PressesBackWithTheSpringWhereTheTipIsBeneathTheSurface) {
  Bench bench;
  bench.step();
  EXPECT_EQ(bench.force(), Vector3::Zero());
  bench.go_to(bench.top + Vector3(0, -0.001, 0), 0.05);
  bench.step();
  const physics::ProxyState& proxy = bench.touch.proxy();
  ASSERT_TRUE(proxy.touching);
  const Vector3 expected = 600.0 * (Vector3(bench.state.bodies[kProxy].p()) - bench.at());
  EXPECT_LT((bench.force() - expected).norm(), 1e-9);
  EXPECT_GT(bench.force().y(), 0.5);
  EXPECT_EQ(bench.state.continuous.touching, 1u);
  EXPECT_EQ(bench.state.counters[kTouches], 1);
  EXPECT_EQ(bench.touch.impact().number, 0u) << "a touch is no blow";
  bench.go_to(bench.top + Vector3(0, 0.02, 0), 0.05);
  EXPECT_EQ(bench.force(), Vector3::Zero());
  EXPECT_EQ(bench.state.continuous.touching, 0u);
  EXPECT_GT(bench.state.counters[kContactMs], 10);
}

TEST(TouchApplication, TheDamperNeitherPullsNorBeginsWithAJump) {
  constexpr double kSpeed = 0.2;
  Bench bench;
  bench.go_to(bench.top + Vector3(0, 0.006, 0), kSpeed);
  double before = 0.0, strongest = 0.0;
  for (int i = 0; i < 60; ++i) {
    bench.tip.velocity = Vector3(0, i < 30 ? -kSpeed : kSpeed, 0);
    bench.tip.X_world_tip.translation += kTick * bench.tip.velocity;
    bench.step();
    const double force = bench.force().y();
    ASSERT_GE(force, 0.0);
    // Per tick of 0.2 mm: the spring's step, and the share of the damper that this is of half a millimetre.
    // A damper that began at once would give 0.52 N.
    if (i < 30) {
      ASSERT_LT(force - before, 600.0 * kSpeed * kTick + 2.0 * kSpeed * 0.4 + 1e-3);
    }
    before = force;
    strongest = std::max(strongest, force);
  }
  EXPECT_GT(strongest, 1.0);
}

// A hand: what arm and hand weigh, pulled after a target by its muscles; the readings have steps like an
// encoder's and the speed comes from them. Pressed on and let be, it has to come to rest.
TEST(TouchApplication, AHandThatPressesComesToRest) {
  for (const double friction : {0.0, 0.3}) {
    Bench bench({}, coarse_for_tests(friction, friction));
    constexpr double kMass = 0.075 + 0.15, kStiffness = 250.0, kDamping = 4.0, kStep = 3e-5;
    Vector3 x = bench.at(), v = Vector3::Zero(), filtered = Vector3::Zero();
    Vector3 low = Vector3::Constant(1e9), high = -low;
    for (int i = 0; i < 3000; ++i) {
      const Vector3 target = bench.top + Vector3(0.004, 0.02 - 0.032 * std::min(1.0, i / 300.0), 0.002);
      const Vector3 seen = (x / kStep).array().round() * kStep;
      filtered += 0.3 * ((seen - bench.at()) / kTick - filtered);
      bench.tip.X_world_tip.translation = seen;
      bench.tip.velocity = filtered;
      bench.step();
      for (int k = 0; k < 4; ++k) {
        const Vector3 force = bench.force() + kStiffness * (target - x) - kDamping * v;
        v += 0.25 * kTick / kMass * force;
        x += 0.25 * kTick * v;
      }
      if (i < 2500) continue;
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    ASSERT_TRUE(bench.touch.proxy().touching);
    EXPECT_GT(bench.force().norm(), 1.0);
    EXPECT_LT((high - low).norm(), 2.0 * kStep) << "friction " << friction;
  }
}

TEST(TouchApplication, AMovingOrganPushesATipThatStandsStillAndNeverPassesIt) {
  Settings settings;
  settings.sway_hz = 5.0;  // up to 0.4 m/s
  settings.sway_m = 0.025;
  settings.sway_rad = 0.2;
  Bench bench(settings, coarse_for_tests());
  bench.tip.X_world_tip.translation = bench.top + Vector3(0.002, 0.010, 0.001);
  bench.step();
  bench.touch.control(scene::Control::begin);
  double strongest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    bench.step();
    const auto& organ = bench.state.bodies[kOrgan];
    const Vector3 in_organ = organ.q().conjugate() * (bench.state.bodies[kProxy].p() - organ.p());
    ASSERT_GT(in_organ.y(), kHalfHeight - 0.003) << "step " << i;
    strongest = std::max(strongest, bench.force().y());
  }
  EXPECT_GT(strongest, 5.0);
  EXPECT_GE(bench.state.counters[kTouches], 9);
  bench.touch.control(scene::Control::begin);
  bench.step();
  EXPECT_EQ(bench.state.bodies[kOrgan].v(), Vector3::Zero());
}

TEST(TouchApplication, ATipThatBeginsInsideFeelsNothingUntilItHasBeenOutside) {
  Bench bench({}, coarse_for_tests());
  bench.tip.X_world_tip.translation = bench.touch.rest().translation;
  bench.step();
  EXPECT_EQ(bench.state.bodies[kProxy].visible, 0u);
  bench.go_to(bench.top + Vector3(0, 0.015, 0), 0.2);
  EXPECT_EQ(bench.force(), Vector3::Zero());
  EXPECT_EQ(bench.state.bodies[kProxy].visible, 1u);
  bench.go_to(bench.top, 0.2);
  EXPECT_GT(bench.force().y(), 0.5);
}

TEST(TouchApplication, ATipThatIsNotANumberOrJumpsGivesNoForce) {
  Bench bench({}, coarse_for_tests());
  bench.step();
  bench.go_to(bench.top, 0.2);
  EXPECT_GT(bench.force().norm(), 0.5);
  const Vector3 place = bench.at();
  bench.tip.X_world_tip.translation.setConstant(std::nan(""));
  bench.step();
  EXPECT_EQ(bench.force(), Vector3::Zero());
  EXPECT_EQ(bench.state.bodies[kStylus].visible, 0u);
  bench.tip.X_world_tip.translation = place - Vector3(0, 0.06, 0);
  bench.step();
  EXPECT_EQ(bench.force(), Vector3::Zero()) << "put there, not moved there";
}

TEST(TouchApplication, PauseTakesTheForceAwayAndResetTheCounts) {
  Bench bench({}, coarse_for_tests());
  bench.step();
  bench.go_to(bench.top, 0.2);
  bench.touch.control(scene::Control::pause);
  bench.step();
  EXPECT_EQ(bench.force(), Vector3::Zero());
  bench.step();
  EXPECT_EQ(bench.touch.contact_law()->force(bench.tip, kTick), Vector3::Zero()) << "nor does the law ask";
  bench.touch.control(scene::Control::resume);
  bench.step();
  bench.step();  // which the law hears of in its next tick
  EXPECT_GT(bench.force().norm(), 0.5);
  bench.touch.control(scene::Control::reset);
  bench.step();
  EXPECT_EQ(bench.state.counters[kTouches], 0);
}

TEST(TouchApplication, StepDoesNotAllocate) {
  Bench bench;
  bench.step();
  const std::size_t before = allocations();
  bench.go_to(bench.top + Vector3(0, -0.002, 0), 0.1);
  bench.go_to(bench.top + Vector3(0.02, -0.004, 0.01), 0.1);
  EXPECT_EQ(allocations() - before, 0u);
}

std::string refusal_of(const Settings& settings, const scene::SceneDescription& scene = table_for_tests()) {
  try {
    const TouchApplication touch(scene, settings);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

TEST(TouchApplication, RefusesSettingsThatCannotBeAndASceneWithoutTable) {
  auto scene = coarse_for_tests();
  EXPECT_EQ(refusal_of({}, scene), "");
  const auto refused = [&](const char* name, double value) {
    return refusal_of({}, with(scene, name, value));
  };
  EXPECT_NE(refused("touch.stiffness_n_m", 3000.0).find("touch: touch.stiffness_n_m: is 3000; 1 to 800"),
            std::string::npos);
  EXPECT_NE(refused("touch.stiffness_n_m", std::nan("")).find("touch: touch.stiffness_n_m: is of another"),
            std::string::npos);
  EXPECT_NE(refused("touch.damping_n_s_m", -1.0).find("touch: touch.damping_n_s_m: is -1"),
            std::string::npos);
  EXPECT_NE(refused("touch.static_friction", 0.1).find("touch: touch.static_friction: at least friction"),
            std::string::npos);
  scene.settings.version = 7;
  EXPECT_NE(refusal_of({}, scene).find("touch: its settings are of version 7, this side knows 1"),
            std::string::npos);
  EXPECT_NE(refusal_of({.sway_m = 1.0}, coarse_for_tests()).find("touch: a sway of"), std::string::npos);
  scene = coarse_for_tests();
  scene.surfaces.clear();
  EXPECT_NE(refusal_of({}, scene).find("no surface 'table'"), std::string::npos);
}

// A cube brought as a mesh stands on the table, turned and shifted as asked, and is as stiff as asked:
// pressed d deep its top gives K d back.
TEST(TouchApplication, AMeshStandsOnTheTableTurnedAndShiftedAndIsAsStiffAsAsked) {
  scene::SceneDescription scene = with(table_for_tests(), "touch.stiffness_n_m", 250.0);
  scene =
      with(scene, "touch.turn_deg", std::vector<double>{90.0, 0.0, 0.0});  // its z, 80 mm, goes up or down
  scene = with(scene, "touch.shift_mm", std::vector<double>{20.0, 5.0, 30.0});
  scene.mesh = scene::MeshAsset{
      .mesh = std::make_shared<scene::TriangleMesh>(scene::box_mesh({0.1, 0.2, 0.3}, {0.14, 0.26, 0.38}))};
  Bench bench({}, scene);
  const double up = -1.52 + 0.005 + 0.080;
  const Vector3 above(0.02, up + 0.02, 1.80 - 0.11 + 0.03);
  bench.tip.X_world_tip.translation = above;
  bench.step();
  bench.go_to({above.x(), up + 0.003 - 0.004, above.z()}, 0.05);
  bench.step();
  EXPECT_NEAR(bench.force().y(), 250.0 * 0.004, 1e-4);
  EXPECT_NEAR(bench.force().head<1>().norm() + std::abs(bench.force().z()), 0.0, 1e-4);
  EXPECT_NEAR(bench.state.counters[kDepthUm], 4000, 1);
  const TouchView scene_view(scene);  // whose mesh the items point to
  const auto items = scene_view.draw(bench.state);
  double highest = -10.0;
  for (const auto& v : items[0].mesh->vertices)
    highest = std::max(highest, (items[0].position + items[0].rotation * v).y());
  EXPECT_NEAR(highest, up, 1e-12) << "the picture shows it where it is felt";
}

// Drawn sideways under the surface the tip sticks until mu_static, then slides at mu: the force rises to the
// one, drops to the other and stays.
TEST(TouchApplication, FrictionHoldsUpToItsStaticValueAndThenDropsToTheSlidingOne) {
  scene::SceneDescription scene = with(table_for_tests(), "touch.damping_n_s_m", 0.0);
  scene = with(with(scene, "touch.static_friction", 0.5), "touch.friction", 0.2);
  scene.mesh = scene::MeshAsset{
      .mesh = std::make_shared<scene::TriangleMesh>(scene::box_mesh({-0.1, -0.02, -0.1}, {0.1, 0.02, 0.1}))};
  Bench bench({}, scene);
  bench.go_to(bench.top + Vector3(-0.01, 0.02, 0), 0.2);
  bench.tip.X_world_tip.translation = bench.touch.rest().translation + Vector3(-0.01, 0.03, 0);
  bench.step();
  const double rest = bench.touch.rest().translation.y() + 0.023;
  bench.go_to({bench.at().x(), rest - 0.004, bench.at().z()}, 0.05);
  const double normal = bench.force().y();
  double most = 0.0, last = 0.0;
  const Vector3 end = bench.at() + Vector3(0.01, 0, 0);
  while ((end - bench.at()).norm() > 1e-9) {
    bench.go_to(bench.at() + Vector3(std::min(2e-5, end.x() - bench.at().x()), 0, 0), 0.02);
    last = -bench.force().x();
    most = std::max(most, last);
  }
  EXPECT_NEAR(normal, 600.0 * 0.004, 1e-4);
  EXPECT_NEAR(most / normal, 0.5, 0.01) << "steps of 20 um";
  EXPECT_NEAR(last / normal, 0.2, 0.001);
  EXPECT_EQ(bench.state.counters[kSlips], 1);
  EXPECT_EQ(bench.state.counters[kSliding], 1);
}

TEST(TouchView, DrawsWhatIsFeltToAFractionOfAMillimetre) {
  const scene::TriangleMesh fine = touched_mesh(table_for_tests()), coarse = drawn_mesh(table_for_tests());
  EXPECT_LT(coarse.triangles.size(), fine.triangles.size() / 6);
  const physics::CollisionMesh felt(fine), drawn(coarse);
  int places = 0;
  double worst = 0.0;
  for (double x = -0.05; x <= 0.05; x += 0.0007)
    for (double z = -0.035; z <= 0.035; z += 0.0011) {
      const auto a = felt.sweep({x, 0.1, z}, {x, -0.1, z}, 1e-4),
                 b = drawn.sweep({x, 0.1, z}, {x, -0.1, z}, 1e-4);
      if (!a || !b) continue;
      ++places;
      worst = std::max(worst, 0.2 * std::abs(a->fraction - b->fraction) * a->normal.y());
    }
  EXPECT_GT(places, 5000);
  EXPECT_LT(worst, 1.5e-4) << "m, across the surface";
}

TEST(TouchView, TheSurfaceHasTheColourThatIsSet) {
  Bench bench;
  bench.step();
  for (const auto& [name, look] : kColours) {
    scene::SceneDescription scene = table_for_tests();
    auto values = scene::from_payload(setting_schema(), scene.settings).value();
    values.set("touch.colour", std::string(name));
    describe(values, scene);
    EXPECT_EQ(TouchView(scene).draw(bench.state)[0].look, look) << name;
  }
}

TEST(TouchView, DrawsTheTipOnTheSurfaceWhereTheHandIsBeneath) {
  Bench bench;
  bench.step();
  const TouchView scene_view(table_for_tests());
  EXPECT_EQ(scene_view.draw(scene::SceneState{}).size(), 0u);
  EXPECT_EQ(scene_view.draw(bench.state).size(), 4u) << "surface, plinth, tip, stylus";
  bench.go_to(bench.top - Vector3(0, 0.002, 0), 0.2);
  const auto items = scene_view.draw(bench.state);
  ASSERT_EQ(items.size(), 6u) << "and ring and line of the contact";
  EXPECT_EQ(items[2].look, kTouchingTipLook);
  EXPECT_GT(items[2].position.y(), bench.at().y() + 0.003);
  // They begin where it touches and stand along the force, farther out the stronger it is.
  const auto reach = [](const scene::DrawItem& item) {
    double farthest = 0.0;
    for (const auto& v : item.mesh->vertices) farthest = std::max(farthest, v.norm());
    return farthest;
  };
  const Vector3 force(bench.state.continuous.force.data());
  for (std::size_t i : {4u, 5u}) {
    EXPECT_LT((items[i].position - Vector3(bench.state.continuous.point.data())).norm(), 1e-12);
    EXPECT_LT((items[i].rotation * Vector3::UnitY() - force.normalized()).norm(), 1e-9);
  }
  scene::SceneState stronger = bench.state;
  for (double& component : stronger.continuous.force) component *= 1.6;
  const auto larger = scene_view.draw(stronger);
  EXPECT_GT(reach(larger[4]), reach(items[4]));
  EXPECT_GT(reach(larger[5]), reach(items[5]));
  EXPECT_EQ(scene_view.captions(bench.state).size(), 2u);
}

}  // namespace
}  // namespace palpate::applications::touch
