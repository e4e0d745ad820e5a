#include "palpate/physics/proxy.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "palpate/math/random_vector.h"
#include "palpate/physics/height_field_for_tests.h"
#include "tests/allocation_count.h"

namespace palpate::physics {
namespace {

constexpr double kRadius = 0.003;

double all_triangles_distance(const scene::TriangleMesh& mesh, const Vector3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const Triangle triangle{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    best = std::min(best, (p - closest_point(triangle, p)).norm());
  }
  return best;
}

scene::TriangleMesh scaled(scene::TriangleMesh mesh, double scale) {
  for (auto& v : mesh.vertices) v *= scale;
  return mesh;
}

TEST(Proxy, IsWhereTheTipIsWhileNothingIsInTheWay) {
  const CollisionMesh mesh(height_field({}, 20));
  Proxy proxy(mesh, {});
  proxy.begin({0, 0, 0.05});
  Random random(1, "proxy/free");
  for (int i = 0; i < 200; ++i) {
    const Vector3 tip = Vector3(0, 0, 0.05) + uniform3(random, 0.03);
    const auto& state = proxy.follow(tip);
    ASSERT_EQ(state.position, tip);
    ASSERT_FALSE(state.touching);
    ASSERT_TRUE(state.settled);
  }
}

TEST(Proxy, SlidingOnAPlaneWithoutFrictionPushesWithTheSameForceEveryTick) {
  const CollisionMesh mesh(height_field({.amplitude = 0.0}, 70));
  for (const double speed : {0.01, 0.1, 1.0}) {
    Proxy proxy(mesh, {.radius = kRadius});
    proxy.begin({-0.08, -0.07, 0.01});
    proxy.follow({-0.08, -0.07, -0.002});
    for (int i = 0; i < 500; ++i) {
      const Vector3 tip = tip_under({.amplitude = 0.0}, speed, 0.002, i * 1e-3);
      const Vector3 push = proxy.follow(tip).position - tip;
      // The skin of a millionth of the radius, and what stands still: 1e-4 of the push of 5 mm.
      ASSERT_NEAR(push.z(), 0.005, 1e-8);
      ASSERT_LT(push.head<2>().norm(), 5e-7);
    }
  }
}

// A groove of 90 degrees and the corner of a room: the nearest place is known in closed form.
TEST(Proxy, RestsAgainstTwoAndThreeWallsAtOnce) {
  scene::TriangleMesh room;
  scene::append(room, scene::rectangle_mesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  scene::append(room, scene::rectangle_mesh({0, 0, 0}, {0, 1, 0}, {0, 0, 1}));
  scene::append(room, scene::rectangle_mesh({0, 0, 0}, {0, 0, 1}, {1, 0, 0}));
  const CollisionMesh mesh(room);
  Random random(2, "proxy/room");
  for (int i = 0; i < 300; ++i) {
    Proxy proxy(mesh, {.radius = kRadius});
    const Vector3 start = Vector3(0.02, 0.02, 0.02) + uniform3(random, 0.015);
    proxy.begin(start);
    const Vector3 tip = Vector3(0.004, 0.004, 0.004) + uniform3(random, 0.012);
    const Vector3 expected = tip.cwiseMax(Vector3::Constant(kRadius));
    const auto& state = proxy.follow(tip);
    ASSERT_LT((state.position - expected).norm(), 5e-7) << "case " << i;
    ASSERT_TRUE(state.settled);
    ASSERT_EQ(state.touching, (expected - tip).norm() > 1e-7);
  }
}

// What the slide answers is judged by all triangles, one by one: the sphere overlaps none, and no place
// beside it that overlaps none is nearer to the tip.
TEST(Proxy, NoPlaceBesideItIsNearerToTheTip) {
  const Bumps bumps{.amplitude = 0.005};
  const scene::TriangleMesh field = height_field(bumps, 24, 0.05), ball = scene::sphere_mesh(0.02, 12, 18);
  Random random(3, "proxy/nearest");
  for (const auto* surface : {&field, &ball}) {
    const CollisionMesh mesh(*surface);
    int contacts = 0;
    for (int i = 0; i < 150; ++i) {
      Proxy proxy(mesh, {.radius = kRadius});
      Vector3 out = normal3(random).normalized();
      out.z() = std::abs(out.z());
      const Vector3 at = surface == &field
                             ? Vector3(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.0)
                             : Vector3(0.02 * out);
      proxy.begin(surface == &field ? Vector3(at + Vector3(0, 0, 0.02)) : Vector3(2.0 * at));
      const Vector3 tip = surface == &field ? Vector3(at.x(), at.y(), bumps.height(at.x(), at.y()) - 0.001)
                                            : Vector3(0.9 * at);
      ProxyState state;
      for (int tick = 0; tick < 5; ++tick) state = proxy.follow(tip);
      ASSERT_TRUE(state.settled);
      const double height = all_triangles_distance(*surface, state.position);
      ASSERT_GT(height, kRadius);
      ASSERT_LT(height, kRadius * (1.0 + 1e-4));
      const double here = (state.position - tip).norm();
      for (int k = 0; k < 60; ++k) {
        const double step = std::pow(10.0, random.uniform(-5.0, -3.5));
        const Vector3 beside = state.position + step * normal3(random).normalized();
        if (all_triangles_distance(*surface, beside) < kRadius) continue;
        // Standing still within a tenth of a micrometre leaves that much to be had.
        ASSERT_GT((beside - tip).norm(), here - 2e-7) << "case " << i << " step " << step;
        ++contacts;
      }
    }
    EXPECT_GT(contacts, 1000);
  }
}

struct Ride {
  int beneath = 0, stuck = 0, unsettled = 0, ticks = 0;
};

Ride ride(const scene::TriangleMesh& surface, std::uint32_t cells, const Bumps& bumps, double speed,
          double friction, int ticks) {
  const CollisionMesh mesh(surface);
  Proxy proxy(mesh, {.radius = kRadius, .friction = friction});
  proxy.begin({-0.08, -0.07, 0.02});
  Ride ride;
  for (int i = 0; i < ticks; ++i) {
    const Vector3 tip = tip_under(bumps, speed, 0.002, i * 1e-3);
    const auto& state = proxy.follow(tip);
    const Vector3& p = state.position;
    ride.beneath += p.z() < flat_height(surface, cells, p.x(), p.y()) + 0.5 * kRadius;
    ride.stuck += (p - tip).norm() > 0.008;
    ride.unsettled += !state.settled;
    ++ride.ticks;
  }
  return ride;
}

TEST(Proxy, NeitherFallsThroughBumpsNorStaysBehindThem) {
  for (const std::uint32_t cells : {22u, 71u, 224u}) {
    for (const double amplitude : {0.005, 0.0005}) {
      const Bumps bumps{amplitude};
      const scene::TriangleMesh surface = height_field(bumps, cells);
      for (const double speed : {0.1, 1.0}) {
        for (const double friction : {0.0, 0.3}) {
          const Ride r = ride(surface, cells, bumps, speed, friction, 1500);
          EXPECT_EQ(r.beneath, 0) << cells << " cells, " << speed << " m/s, friction " << friction;
          EXPECT_EQ(r.stuck, 0) << cells << " cells, " << speed << " m/s, friction " << friction;
          EXPECT_LE(r.unsettled, r.ticks / 100) << cells << " cells";
        }
      }
    }
  }
}

TEST(Proxy, TapsOnVerticesEdgesAndFacesAreHeldUpAtAnySpeed) {
  constexpr std::uint32_t kCells = 71;
  const Bumps bumps;
  const scene::TriangleMesh surface = height_field(bumps, kCells);
  const CollisionMesh mesh(surface);
  Random random(4, "proxy/taps");
  for (int i = 0; i < 900; ++i) {
    const auto& t = surface.triangles[random.below(surface.triangles.size())];
    const Vector3 &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
    const Vector3 at = i % 3 == 0 ? a : i % 3 == 1 ? Vector3(0.5 * (a + b)) : Vector3((a + b + c) / 3.0);
    if (at.head<2>().lpNorm<Eigen::Infinity>() > 0.09) continue;
    const double speed = std::array{0.05, 0.1, 0.5, 1.0, 5.0}[random.below(5)];
    Proxy proxy(mesh, {.radius = kRadius});
    double z = at.z() + 0.012;
    proxy.begin({at.x(), at.y(), z});
    while (z > at.z() - 0.004) {
      z -= 1e-3 * speed;
      const auto& state = proxy.follow({at.x(), at.y(), z});
      const Vector3& p = state.position;
      ASSERT_GT(p.z(), flat_height(surface, kCells, p.x(), p.y()) + 0.9 * kRadius) << "case " << i;
    }
    ASSERT_GT(proxy.state().depth, 0.001);
  }
}

TEST(Proxy, FrictionOnAPlaneHoldsInsideTheConeAndSlidesOnItOutside) {
  const CollisionMesh mesh(height_field({.amplitude = 0.0}, 70));
  constexpr double kFriction = 0.3, kDepth = 0.002;
  Proxy proxy(mesh, {.radius = kRadius, .friction = kFriction});
  proxy.begin({0, 0, 0.01});
  const auto at = [](double x, double y) { return Vector3(x, y, kRadius - kDepth); };
  const Vector3 landed = proxy.follow(at(0, 0)).position;
  for (int i = 1; i <= 59; ++i) {  // to 0.59 mm of the 0.6 the cone is wide
    const auto& state = proxy.follow(at(1e-5 * i, 0));
    ASSERT_EQ(state.position, landed) << "held, and not by a hair further";
    ASSERT_FALSE(state.sliding);
  }
  for (int i = 1; i <= 400; ++i) {  // a quarter of a circle, 1 m/s
    const double angle = i / 400.0 * 1.57;
    const Vector3 tip = at(0.0006 + 0.2 * 0.254 * std::sin(angle), 0.2 * 0.254 * (1.0 - std::cos(angle)));
    const auto& state = proxy.follow(tip);
    const Vector3 push = state.position - tip;
    ASSERT_NEAR(push.z(), kDepth, 1e-8);
    ASSERT_NEAR(push.head<2>().norm(), kFriction * kDepth, 1e-6);
    if (i > 20) {
      const Vector3 way(std::cos(angle), std::sin(angle), 0.0);
      ASSERT_LT(push.normalized().dot(way), 0.0) << "friction pulls back";
    }
  }
}

// A tip pressed straight down on a slope: held where tan(slope) is less than the friction, else it creeps
// off.
TEST(Proxy, ASlopeHoldsTheTipWhereItsTangentIsLessThanTheFriction) {
  for (const double slope : {0.25, 0.35}) {
    const CollisionMesh mesh(scene::rectangle_mesh({-1, -1, -slope}, {2, 0, 2 * slope}, {0, 2, 0}));
    Proxy proxy(mesh, {.radius = kRadius, .friction = 0.3});
    const double rest = kRadius * std::sqrt(1.0 + slope * slope);  // height of a resting centre over x = 0
    proxy.begin({0, 0, 0.01});
    proxy.follow({0, 0, rest - 1e-6});
    const Vector3 landed = proxy.state().position;
    for (int i = 1; i < 200; ++i) proxy.follow({0, 0, rest - 1e-5 * i});
    const double crept = landed.x() - proxy.state().position.x();
    if (slope < 0.3) {
      EXPECT_EQ(crept, 0.0);
    } else {
      EXPECT_GT(crept, 5e-5);
    }
  }
}

TEST(Proxy, OnBumpsTheForceStaysOnTheConeWhileSliding) {
  const Bumps bumps;
  const CollisionMesh mesh(height_field(bumps, 224));
  constexpr double kFriction = 0.3;
  Proxy proxy(mesh, {.radius = kRadius, .friction = kFriction});
  proxy.begin({-0.08, -0.07, 0.02});
  int sliding = 0;
  for (int i = 0; i < 1500; ++i) {
    const Vector3 tip = tip_under(bumps, 0.2, 0.002, i * 1e-3);
    const auto& state = proxy.follow(tip);
    if (!state.touching) continue;
    const Vector3 push = state.position - tip;
    const double along = push.dot(state.normal), aside = (push - along * state.normal).norm();
    ASSERT_LT(aside, 1.05 * kFriction * along + 1e-7) << "tick " << i;
    sliding += state.sliding;
  }
  EXPECT_GT(sliding, 1300);
}

TEST(Proxy, DoesTheSameInMillimetresAndInKilometres) {
  const Bumps bumps;
  const scene::TriangleMesh surface = height_field(bumps, 40);
  const CollisionMesh metres(surface);
  for (const double scale : {1e3, 1e-3}) {
    const CollisionMesh other(scaled(surface, scale));
    Proxy a(metres, {.radius = kRadius, .friction = 0.3});
    Proxy b(other, {.radius = scale * kRadius, .friction = 0.3});
    a.begin({-0.08, -0.07, 0.02});
    b.begin(scale * Vector3(-0.08, -0.07, 0.02));
    for (int i = 0; i < 400; ++i) {
      const Vector3 tip = tip_under(bumps, 0.5, 0.002, i * 1e-3);
      const Vector3 p = a.follow(tip).position, q = b.follow(scale * tip).position / scale;
      ASSERT_LT((p - q).norm(), 1e-5) << "tick " << i;  // rounding may end a slide one round later
    }
  }
}

TEST(Proxy, ATipThatIsNotANumberChangesNothingAndAJumpIsFollowedWithoutFallingThrough) {
  const CollisionMesh mesh(height_field({}, 40));
  Proxy proxy(mesh, {.radius = kRadius});
  proxy.begin({0, 0, 0.02});
  const Vector3 before = proxy.follow({0, 0, -0.002}).position;
  const double bad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(proxy.follow({bad, 0, 0}).position, before);
  EXPECT_EQ(proxy.follow({0, std::numeric_limits<double>::infinity(), 0}).position, before);
  const auto& deep = proxy.follow({0.01, 0, -5.0});  // 5 m under the floor in one tick
  EXPECT_TRUE(deep.position.allFinite());
  EXPECT_GT(deep.position.z(), -0.005);
}

TEST(Proxy, KnowsWhereASphereIsClear) {
  const scene::TriangleMesh surface = height_field({}, 30);
  const CollisionMesh mesh(surface);
  const Proxy proxy(mesh, {.radius = kRadius});
  Random random(5, "proxy/clear");
  int clear = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3 p(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), random.uniform(-0.012, 0.012));
    const bool expected = all_triangles_distance(surface, p) > kRadius * (1.0 + 1e-4);
    ASSERT_EQ(proxy.clear_at(p), expected) << "case " << i;
    clear += expected;
  }
  EXPECT_GT(clear, 50);
  EXPECT_LT(clear, 250);
}

TEST(Proxy, FollowingAllocatesNothing) {
  const Bumps bumps;
  const CollisionMesh mesh(height_field(bumps, 60));
  Proxy proxy(mesh, {.radius = kRadius, .friction = 0.3});
  proxy.begin({-0.08, -0.07, 0.02});
  const std::size_t before = allocations();
  for (int i = 0; i < 500; ++i) proxy.follow(tip_under(bumps, 1.0, 0.002, i * 1e-3));
  EXPECT_EQ(allocations() - before, 0u);
}

std::string refusal(const ProxySettings& settings) {
  const CollisionMesh mesh(height_field({}, 2));
  try {
    const Proxy proxy(mesh, settings);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

TEST(Proxy, RefusesSettingsThatCannotBeByName) {
  EXPECT_NE(refusal({.radius = 0.0}).find("proxy: radius 0 m"), std::string::npos);
  EXPECT_NE(refusal({.radius = std::nan("")}).find("proxy: radius nan m"), std::string::npos);
  EXPECT_NE(refusal({.friction = -0.1}).find("proxy: friction -0.1"), std::string::npos);
  EXPECT_NE(refusal({.friction = 3.0}).find("proxy: friction 3"), std::string::npos);
  EXPECT_NE(refusal({.most_sweeps = 1}).find("proxy: 1 sweeps"), std::string::npos);
}

}  // namespace
}  // namespace palpate::physics
