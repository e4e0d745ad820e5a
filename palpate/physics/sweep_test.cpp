#include "palpate/physics/sweep.h"

#include <gtest/gtest.h>

#include "palpate/math/random_vector.h"

namespace palpate::physics {
namespace {

double distance_to(const scene::TriangleMesh& mesh, const Vector3& p) {
  double best = 1e300;
  for (const auto& t : mesh.triangles) {
    best = std::min(
        best, (p - closest_point({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, p)).norm());
  }
  return best;
}

// Distance to a triangle without Voronoi regions: the foot on the face if it lies inside, else the nearest
// edge.
double plain_distance(const Triangle& t, const Vector3& p) {
  const Vector3 n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  bool inside = true;
  double best = 1e300;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 a = t[i], e = t[(i + 1) % 3] - a;
    inside = inside && n.dot(e.cross(p - a)) >= 0.0;
    best = std::min(best, (p - a - std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0) * e).norm());
  }
  return inside ? std::abs(n.dot(p - t[0])) : best;
}

TEST(Sweep, ClosestPointAgreesWithFeetOnFaceAndEdges) {
  Random random(1, "sweep/closest");
  for (int i = 0; i < 5000; ++i) {
    const Triangle t{uniform3(random, 1), uniform3(random, 1), uniform3(random, 1)};
    const Vector3 p = uniform3(random, 2);
    ASSERT_NEAR((p - closest_point(t, p)).norm(), plain_distance(t, p), 1e-12);
  }
}

// Against marching along the path: the sphere touches at the stated time and not before; no stated touch, no
// overlap.
TEST(Sweep, TouchesOneTriangleWhenMarchingSaysSo) {
  Random random(2, "sweep/march");
  int hits = 0, faces = 0;
  for (int i = 0; i < 4000; ++i) {
    const Triangle t{uniform3(random, 1), uniform3(random, 1), uniform3(random, 1)};
    const double radius = random.uniform(0.05, 0.4);
    const Vector3 from = uniform3(random, 2), to = uniform3(random, 2);
    if (plain_distance(t, from) <= radius) continue;
    const auto hit = sweep_sphere(t, from, to, radius);
    constexpr int kSteps = 400;
    const double last = hit ? hit->fraction : 1.0;
    for (int k = 0; k <= kSteps; ++k) {
      // 1e-9: where the sphere only grazes, rounding decides whether it touches
      ASSERT_GT(plain_distance(t, from + last * k / kSteps * (to - from)), radius - 1e-9) << "case " << i;
    }
    if (!hit) continue;
    ++hits;
    const Vector3 centre = from + hit->fraction * (to - from);
    ASSERT_NEAR(plain_distance(t, centre), radius, 1e-9);
    ASSERT_NEAR((centre - hit->point).norm(), radius, 1e-9);
    ASSERT_NEAR((hit->point + radius * hit->normal - centre).norm(), 0.0, 1e-9);
    ASSERT_LT(hit->normal.dot(to - from), 1e-9);
    const Vector3 n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    faces += std::abs(std::abs(n.dot(hit->normal)) - 1.0) < 1e-9;
  }
  EXPECT_GT(hits, 400);  // the test has seen enough of each
  EXPECT_GT(faces, 100);
  EXPECT_GT(hits - faces, 100);  // edges and corners
}

TEST(Sweep, AnOverlappingSphereHitsOnlyGoingDeeper) {
  const Triangle t{Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 0, -1)};  // faces up
  const Vector3 inside(0.2, 0.01, -0.2);
  const auto deeper = sweep_sphere(t, inside, inside - Vector3(0, 0.005, 0), 0.02);
  ASSERT_TRUE(deeper);
  EXPECT_EQ(deeper->fraction, 0.0);
  EXPECT_TRUE(deeper->overlapped);
  EXPECT_NEAR((deeper->normal - Vector3::UnitY()).norm(), 0.0, 1e-12);
  EXPECT_FALSE(sweep_sphere(t, inside, inside + Vector3(0, 0.1, 0), 0.02));
  EXPECT_FALSE(sweep_sphere(t, inside, inside, 0.02));
}

TEST(Sweep, AFlatRayOfTheCentreMissesWhatTheSphereTouches) {
  // The paper's ray, lengthened by the radius: grazing flight touches the plate long before the ray does.
  const Triangle t{Vector3(-1, 0, 1), Vector3(1, 0, 1), Vector3(0, 0, -2)};
  const Vector3 from(0, 0.03, 0.5), d(0, -0.02, -0.1);
  EXPECT_TRUE(sweep_sphere(t, from, from + d, 0.02));
  EXPECT_FALSE(ray_triangle(t, from, from + d + 0.02 * d.normalized()));
  EXPECT_TRUE(ray_triangle(t, from, from + 2.0 * d));
}

TEST(Sweep, TheTreeFindsWhatBruteForceFinds) {
  Random random(3, "sweep/tree");
  scene::TriangleMesh mesh;  // a bumpy field of 2 * 24^2 triangles
  constexpr std::uint32_t n = 25;
  for (std::uint32_t i = 0; i < n * n; ++i) {
    mesh.vertices.push_back({0.08 * (i % n) - 1, random.uniform(-0.05, 0.05), 0.08 * (i / n) - 1});
  }
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    for (std::uint32_t j = 0; j + 1 < n; ++j) {
      const std::uint32_t a = i * n + j;
      mesh.triangles.push_back({a, a + n, a + 1});
      mesh.triangles.push_back({a + 1, a + n, a + n + 1});
    }
  }
  const CollisionMesh tree(mesh);
  int hits = 0;
  for (int k = 0; k < 500; ++k) {
    const Vector3 from = uniform3(random, 1.0).cwiseProduct(Vector3(1, 0.15, 1));
    const Vector3 to = from + uniform3(random, 0.2);
    std::optional<SweepHit> best;
    std::optional<double> ray;
    for (const auto& t : mesh.triangles) {
      const Triangle triangle{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
      const auto hit = sweep_sphere(triangle, from, to, 0.02);
      if (hit && (!best || hit->fraction < best->fraction)) best = hit;
      const auto crossing = ray_triangle(triangle, from, to);
      if (crossing && (!ray || *crossing < *ray)) ray = crossing;
    }
    const auto found = tree.sweep(from, to, 0.02);
    ASSERT_EQ(found.has_value(), best.has_value());
    if (best) {
      ASSERT_EQ(found->fraction, best->fraction);
    }
    const auto seen = tree.ray(from, to);
    ASSERT_EQ(seen.has_value(), ray.has_value());
    if (ray) {
      ASSERT_EQ(seen->fraction, *ray);
    }
    hits += best.has_value();
  }
  EXPECT_GT(hits, 100);
}

// Brute force: march a thousand times finer than the step, and ask for the distance in the bat's frame.
TEST(Sweep, AMovingBatIsMetWhenFineMarchingSaysSo) {
  Random random(4, "sweep/moving");
  const auto disc = scene::disc_mesh(0.075, 0.012, 24);
  const CollisionMesh bat(disc);
  const double radius = 0.02;
  int hits = 0;
  for (int k = 0; k < 150; ++k) {
    const Pose<World, Bat> X0{so3_exp(uniform3(random, 2)), uniform3(random, 0.05)};
    const Pose<World, Bat> X1{(so3_exp(uniform3(random, 0.03)) * X0.rotation).normalized(),
                              X0.translation + uniform3(random, 0.01)};
    const double speed = std::exp(random.uniform(std::log(0.5), std::log(100.0)));
    // Aimed at a point of the blade, from a little further away than one step leads.
    const double travel = 0.001 * speed;
    const Point<Bat> spot{{random.uniform(-0.07, 0.07), 0.0, random.uniform(-0.07, 0.07)}};
    const Vector3 u = uniform3(random, 1).normalized();
    const Vector3 from = (X0 * spot).m + (radius + 0.007 + random.uniform(0.0, 0.8) * travel) * u;
    const Vector3 to = from - travel * u;
    const auto gap = [&](double s) {
      const auto X = interpolate(X0, X1, s);
      return distance_to(disc, (X.inverse() * Point<World>{from + s * (to - from)}).m) - radius;
    };
    if (gap(0.0) <= 0.0) continue;
    const auto hit = sweep_moving(bat, X0, X1, from, to, radius);
    constexpr int kSteps = 100;
    const double last = hit ? hit->fraction : 1.0;
    // The bend of the path within a part is at most 0.1 mm by construction.
    for (int i = 0; i < kSteps; ++i) ASSERT_GT(gap(last * i / kSteps), -1.1e-4) << "case " << k;
    if (!hit) continue;
    ++hits;
    ASSERT_NEAR(gap(hit->fraction), 0.0, 1.1e-4);
  }
  EXPECT_GT(hits, 20);
}

TEST(Sweep, BadMeshesAreRefused) {
  EXPECT_THROW(CollisionMesh({{Vector3::Zero()}, {{0, 1, 2}}}), std::invalid_argument);
  EXPECT_THROW(CollisionMesh({{Vector3(0, std::nan(""), 0)}, {}}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::physics
