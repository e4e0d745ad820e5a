// The sweep beside the same question answered in 80-bit floats by other mathematics (sweep_reference_test.h);
// in any unit of length; against meshes of 2 to 1,000,000 triangles; and the bounce that comes of it.
#include <gtest/gtest.h>

#include "palpate/core/units.h"
#include "palpate/math/random_vector.h"
#include "palpate/physics/ball.h"
#include "palpate/physics/height_field_for_tests.h"
#include "palpate/physics/sweep.h"
#include "palpate/physics/sweep_reference_test.h"

namespace palpate::physics {
namespace {

using reference::Long;

std::vector<Triangle> triangles_of(const scene::TriangleMesh& mesh) {
  std::vector<Triangle> all;
  for (const auto& t : mesh.triangles)
    all.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  return all;
}

// Good triangles, needles, slivers, single points and segments.
Triangle any_triangle(Random& random) {
  Triangle t{uniform3(random, 1), uniform3(random, 1), uniform3(random, 1)};
  const double thin = std::exp(random.uniform(std::log(1e-14), 0.0));
  switch (random.below(6)) {
    case 0:
      t[2] = t[0] + random.uniform() * (t[1] - t[0]) + thin * uniform3(random, 1);
      break;
    case 1:
      t[1] = t[0] + thin * uniform3(random, 1);
      break;
    case 2:
      t[random.below(3)] = t[random.below(3)];
      break;
    case 3:
      t = {t[0], t[0], t[0]};
      break;
    default:
      break;
  }
  return t;
}

// Aimed at a face, an edge or a corner, straight or grazing, from near or far.
struct Shot {
  Vector3 from, to;
  double radius;
};
Shot any_shot(const Triangle& t, Random& random) {
  Vector3 w(random.uniform(), random.uniform(), random.uniform());
  if (random.chance(0.5)) w[static_cast<Eigen::Index>(random.below(3))] = 0.0;
  if (random.chance(0.3)) w[static_cast<Eigen::Index>(random.below(3))] = 0.0;
  if (w.sum() == 0.0) w.x() = 1.0;
  w /= w.sum();
  const Vector3 aim = w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
  Shot shot;
  shot.radius = std::exp(random.uniform(std::log(1e-3), 0.0));
  const Vector3 u = uniform3(random, 1).normalized();
  // Off the aim by up to the radius and a little more: grazing touches and near misses.
  const Vector3 off =
      u.unitOrthogonal() * shot.radius * (random.chance(0.5) ? random.uniform(0.95, 1.01) : random.uniform());
  shot.from = aim + off - u * shot.radius * random.uniform(1.0, 8.0);
  shot.to = shot.from + u * shot.radius * std::exp(random.uniform(std::log(1e-3), std::log(20.0)));
  return shot;
}

TEST(SweepExact, TouchesWhenTheLongArithmeticSaysSo) {
  Random random(1, "sweep/exact");
  int hits = 0, misses = 0, near = 0;
  for (int k = 0; k < 9000; ++k) {
    const Triangle t = any_triangle(random);
    const Shot shot = any_shot(t, random);
    const auto path = reference::path(shot.from, shot.to);
    if (reference::distance(t, path.at(0)) <= Long(shot.radius)) continue;
    // Rounding of the path's own places, not more: they are of order 1.
    const double rounding = 4e-15 * (1.0 + shot.from.norm() + shot.to.norm());
    const auto hit = sweep_sphere(t, shot.from, shot.to, shot.radius);
    const auto lowest = reference::nearest(t, path);
    near += std::abs(static_cast<double>(lowest.distance) - shot.radius) < 0.01 * shot.radius;
    if (!hit) {
      ++misses;
      ASSERT_GT(lowest.distance, Long(shot.radius) - rounding) << "case " << k;
      continue;
    }
    ++hits;
    // Where the path grazes, the moment is loose but the distance is not: it stays the radius, to rounding,
    // and is not less at any moment before.
    const Long at = hit->fraction;
    ASSERT_NEAR(static_cast<double>(reference::distance(t, path.at(at)) - Long(shot.radius)), 0.0, rounding)
        << "case " << k;
    const Long true_at = reference::touch(t, path, Long(shot.radius) + rounding);
    ASSERT_LE(true_at, 1) << "case " << k;
    for (int i = 0; i <= 16; ++i)
      ASSERT_GT(reference::distance(t, path.at(at * i / 16)), Long(shot.radius) - rounding) << "case " << k;
    ASSERT_NEAR(hit->normal.norm(), 1.0, 1e-14);
    // The point lies on the triangle and, along the normal, a radius from the centre. The normal may be the
    // face's where the edge's is the same to the square root of rounding.
    ASSERT_LT(static_cast<double>(reference::distance(t, hit->point.cast<Long>())), rounding) << "case " << k;
    const Vector3 centre = shot.from + hit->fraction * (shot.to - shot.from);
    ASSERT_NEAR(hit->normal.dot(centre - hit->point), shot.radius, 4 * rounding) << "case " << k;
  }
  EXPECT_GT(hits, 1500);
  EXPECT_GT(misses, 500);
  EXPECT_GT(near, 60);
}

TEST(SweepExact, AnOverlapIsOneWhereTheLongArithmeticSaysSo) {
  Random random(2, "sweep/overlap");
  int deeper = 0, leaving = 0;
  for (int k = 0; k < 6000; ++k) {
    const Triangle t = any_triangle(random);
    const Shot shot = any_shot(t, random);
    const auto path = reference::path(shot.from, shot.to);
    const Long at_start = reference::distance(t, path.at(0));
    // A needle's closest point is known to the square root of rounding across it.
    if (at_start > 0.999L * shot.radius || at_start < 0.01L * shot.radius) continue;
    const Long soon = reference::distance(t, path.at(1e-7L));
    const Long change = (soon - at_start) / (1e-7L * path.d.norm());
    if (std::abs(change) < 1e-4L) continue;  // along the surface: either answer will do
    const auto hit = sweep_sphere(t, shot.from, shot.to, shot.radius);
    ASSERT_EQ(hit.has_value(), change < 0) << "case " << k;
    if (!hit) {
      ++leaving;
      continue;
    }
    ++deeper;
    ASSERT_TRUE(hit->overlapped);
    ASSERT_EQ(hit->fraction, 0.0);
  }
  EXPECT_GT(deeper, 200);
  EXPECT_GT(leaving, 50);
}

// What CollisionMesh spares itself: triangles that cannot be the first any more.
TEST(SweepExact, AskedUpToAFractionItTellsTheSameTouchOrThatThereIsNone) {
  Random random(9, "sweep/latest");
  int told = 0, spared = 0;
  for (int k = 0; k < 200'000; ++k) {
    const Triangle t = any_triangle(random);
    const Shot shot = any_shot(t, random);
    const auto whole = sweep_sphere(t, shot.from, shot.to, shot.radius);
    const double latest = k % 3 == 0 && whole ? whole->fraction : random.uniform();
    const auto part = sweep_sphere(t, shot.from, shot.to, shot.radius, latest);
    if (part) {
      ASSERT_TRUE(whole);
      ASSERT_EQ(part->fraction, whole->fraction);
      ASSERT_EQ(part->normal, whole->normal);
      ++told;
    } else if (whole) {
      ASSERT_GT(whole->fraction, latest);
      ++spared;
    }
  }
  EXPECT_GT(told, 10'000);
  EXPECT_GT(spared, 10'000);
}

// Triangles of all sizes and shapes without order, which no height field is.
scene::TriangleMesh soup(std::size_t count, Random& random) {
  scene::TriangleMesh mesh;
  for (std::size_t k = 0; k < count; ++k) {
    const double size = std::exp(random.uniform(std::log(1e-4), std::log(0.3)));
    const Vector3 at = uniform3(random, 1.0);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int i = 0; i < 3; ++i) mesh.vertices.push_back(at + uniform3(random, size));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  for (int i = 0; i < 8; ++i) mesh.triangles.push_back({0, 1, 2});  // the same in one place: cannot be split
  return mesh;
}

std::optional<SweepHit> one_by_one(const std::vector<Triangle>& triangles, const Vector3& from,
                                   const Vector3& to, double radius) {
  std::optional<SweepHit> best;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    auto hit = sweep_sphere(triangles[i], from, to, radius);
    if (!hit) continue;
    hit->triangle = i;
    const auto depth = [&](const SweepHit& h) { return (from - h.point).squaredNorm(); };
    if (!best || (hit->overlapped && !best->overlapped) ||
        (hit->overlapped == best->overlapped &&
         (hit->overlapped ? depth(*hit) < depth(*best) : hit->fraction < best->fraction)))
      best = hit;
  }
  return best;
}

TEST(SweepExact, TheTreeGivesTheVeryAnswerOfTryingAll) {
  Random random(3, "sweep/tree/all");
  int hits = 0, overlaps = 0, rays = 0;
  for (const std::size_t count : {0u, 1u, 3u, 5u, 17u, 400u, 3000u}) {
    for (const bool flat : {false, true}) {
      auto mesh =
          flat ? rough_field(static_cast<std::uint32_t>(std::sqrt(0.5 * static_cast<double>(count))) + 1,
                             0.02, random)
               : soup(count, random);
      if (count == 0) mesh.triangles.clear();
      const auto triangles = triangles_of(mesh);
      const CollisionMesh prepared(mesh);
      for (int k = 0; k < 300; ++k) {
        const double radius = std::exp(random.uniform(std::log(1e-3), std::log(0.2)));
        Vector3 from = uniform3(random, 1.2);
        Vector3 d = uniform3(random, 1.0) * std::exp(random.uniform(std::log(1e-3), std::log(3.0)));
        if (random.chance(0.3))
          d[static_cast<Eigen::Index>(random.below(3))] = 0.0;  // along a plane of boxes
        if (!triangles.empty() && random.chance(0.7)) {         // aimed
          const Vector3 aim = triangles[random.below(triangles.size())][random.below(3)];
          from = aim - random.uniform() * d + radius * uniform3(random, 1.0);
        }
        const auto expected = one_by_one(triangles, from, from + d, radius);
        const auto found = prepared.sweep(from, from + d, radius);
        ASSERT_EQ(found.has_value(), expected.has_value()) << count << " triangles, case " << k;
        if (expected) {
          ASSERT_EQ(found->fraction, expected->fraction);
          ASSERT_EQ(found->triangle, expected->triangle);
          ASSERT_EQ(found->normal, expected->normal);
          ++hits;
          overlaps += expected->overlapped;
        }
        std::optional<double> first;
        for (const auto& t : triangles)
          if (const auto s = ray_triangle(t, from, from + d); s && (!first || *s < *first)) first = s;
        const auto seen = prepared.ray(from, from + d);
        ASSERT_EQ(seen.has_value(), first.has_value());
        if (first) {
          ASSERT_EQ(seen->fraction, *first);
          ++rays;
        }
      }
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(overlaps, 300);
  EXPECT_GT(rays, 300);
}

TEST(SweepExact, TheUnitOfLengthChangesNothing) {
  Random random(4, "sweep/unit");
  for (int k = 0; k < 60; ++k) {
    const auto metres = k % 2 ? soup(300, random) : rough_field(12, 0.03, random);
    // Powers of two change no digit, so not one bit of the answer; millimetres round each number once.
    for (const double unit : {std::ldexp(1.0, 20), std::ldexp(1.0, -20), kMillimetresPerMetre}) {
      const bool exact = unit != kMillimetresPerMetre;
      auto scaled = metres;
      for (auto& v : scaled.vertices) v *= unit;
      const CollisionMesh a(metres), b(scaled);
      for (int i = 0; i < 20; ++i) {
        const Vector3 from = uniform3(random, 1.0), to = from + uniform3(random, 0.3);
        const double radius = random.uniform(0.001, 0.05);
        const auto in_metres = a.sweep(from, to, radius);
        const auto in_units = b.sweep(unit * from, unit * to, unit * radius);
        ASSERT_EQ(in_metres.has_value(), in_units.has_value());
        if (!in_metres) continue;
        ASSERT_EQ(in_metres->overlapped, in_units->overlapped);
        if (exact) {
          ASSERT_EQ(in_metres->fraction, in_units->fraction);
          ASSERT_EQ(in_metres->normal, in_units->normal);
          ASSERT_EQ(in_metres->triangle, in_units->triangle);
        } else {
          ASSERT_NEAR(in_metres->fraction, in_units->fraction, 1e-9);  // where it grazes, rounding's root
        }
      }
    }
  }
}

TEST(SweepExact, NoRayAndNoSphereSlipsThroughASeam) {
  Random random(5, "sweep/seam");
  const std::uint32_t side = 16;
  const auto mesh = rough_field(side, 0.05, random);
  const CollisionMesh prepared(mesh);
  for (int k = 0; k < 20000; ++k) {
    // Aimed at a vertex or at a point of an edge, to the last bit it can be.
    const auto& t = mesh.triangles[random.below(mesh.triangles.size())];
    const std::size_t i = random.below(3);
    const double s = random.chance(0.3) ? 0.0 : random.uniform();
    const Vector3 aim = mesh.vertices[t[i]] + s * (mesh.vertices[t[(i + 1) % 3]] - mesh.vertices[t[i]]);
    if (std::max(std::abs(aim.x()), std::abs(aim.z())) > 0.6) continue;  // not past the rim
    Vector3 u = uniform3(random, 1.0);
    u.y() = (random.chance(0.5) ? 1.0 : -1.0) * (0.6 + std::abs(u.y()));  // begins above all bumps
    u.normalize();
    const Vector3 from = aim + 0.3 * u, to = aim - 0.3 * u;
    ASSERT_TRUE(prepared.ray(from, to)) << "case " << k;
    ASSERT_TRUE(prepared.sweep(from, to, std::exp(random.uniform(std::log(1e-9), std::log(0.02)))));
  }
}

// The ball of the game on level fields of every size, aimed at faces, edges and vertices, straight down to
// grazing, in metres and in millimetres: it comes back with the restitution, and is never on the other side.
TEST(SweepExact, RestitutionIsExactFromWalkingPaceToAHundredMetresPerSecond) {
  Random random(6, "sweep/restitution");
  double worst = 0.0;
  int bounces = 0;
  for (const std::uint32_t side : {1u, 22u, 224u, 708u}) {  // 2, 968, 100,352 and 1,002,528 triangles
    const auto metres = rough_field(side, 0.0, random);
    for (const double unit : {1.0, kMillimetresPerMetre}) {
      auto mesh = metres;
      // Turned and shifted, so that no coordinate of the level is special.
      const Quaternion turn = so3_exp(Vector3(0.4, -0.3, 0.7));
      const Vector3 shift(0.31, -1.52, 0.8);
      for (auto& v : mesh.vertices) v = unit * (turn * v + shift);
      const Vector3 up = turn * Vector3::UnitY();
      const CollisionMesh prepared(mesh);
      BallModel ball = BallModel::paper();
      ball.gravity.setZero();
      ball.radius = 0.02 * unit;
      for (int k = 0; k < 400; ++k) {
        const double speed = unit * std::exp(random.uniform(std::log(0.1), std::log(100.0)));
        const double lean = k % 3 == 0   ? 0.0
                            : k % 3 == 1 ? random.uniform(0.0, 1.4)
                                         : random.uniform(1.4, 1.56);
        const double turned = random.uniform(0.0, 6.28);
        const Vector3 u = turn * Vector3(std::sin(lean) * std::cos(turned), std::cos(lean),
                                         std::sin(lean) * std::sin(turned));
        const auto& t = metres.triangles[random.below(metres.triangles.size())];
        Vector3 w(random.uniform(), random.uniform(), random.uniform());
        if (k % 4 == 1) w[0] = 0.0;                                 // an edge
        if (k % 4 == 2) w = Vector3(1.0, 0.0, 0.0);                 // a vertex
        if (k % 4 == 3) w[0] = std::exp(random.uniform(-36, -14));  // beside an edge by less than 1 um
        w /= w.sum();
        Vector3 local =
            w[0] * metres.vertices[t[0]] + w[1] * metres.vertices[t[1]] + w[2] * metres.vertices[t[2]];
        if (side == 1) local *= 0.9;  // not off the rim
        if (std::max(std::abs(local.x()), std::abs(local.z())) > 0.95) continue;
        const double dt = 0.001;
        BallState state;
        state.velocity = -speed * u;
        state.position =
            unit * (turn * local + shift) + ball.radius * up + random.uniform(0.0, 1.0) * dt * speed * u;
        const double approach = -up.dot(state.velocity);
        int touches = 0;
        for (int step = 0; step < 3; ++step) {
          double left = 1.0;
          for (int event = 0; event < 4 && left > 0.0; ++event) {
            const BallState next = fly(ball, state, left * dt);
            const auto hit = prepared.sweep(state.position, next.position, ball.radius);
            if (!hit) {
              state = next;
              break;
            }
            state.position += hit->fraction * (next.position - state.position);
            state = bounce(ball, state, hit->normal, {0.93, 0.0});
            left *= 1.0 - hit->fraction;
            ++touches;
          }
          ASSERT_GT(up.dot(state.position / unit - shift), 0.02 - 1e-14) << side << " case " << k;
        }
        ASSERT_EQ(touches, 1) << side << " case " << k;
        ++bounces;
        worst = std::max(worst, std::abs(up.dot(state.velocity) / approach - 0.93));
      }
    }
  }
  EXPECT_GT(bounces, 2500);
  EXPECT_LT(worst, 1e-9);
  RecordProperty("worst_restitution_error", std::to_string(worst));
}

// The path a turning mesh sees is an arc; how far the straight parts are from it is measured, finely, and is
// within what sweep_parts() promises.
TEST(SweepExact, TheBendOfATurningMeshsPathStaysWithinItsBound) {
  Random random(7, "sweep/bend");
  double worst = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const double unit = k % 2 ? 1.0 : kMillimetresPerMetre;
    const double extent = unit * std::exp(random.uniform(std::log(0.05), std::log(2.0)));
    const double radius = unit * std::exp(random.uniform(std::log(0.001), std::log(0.05)));
    const Vector3 w =
        uniform3(random, 1).normalized() * std::exp(random.uniform(std::log(1e-3), std::log(3.0)));
    const Pose<World, Bat> X0{so3_exp(uniform3(random, 2)), uniform3(random, unit)};
    const Pose<World, Bat> X1{(so3_exp(w) * X0.rotation).normalized(),
                              X0.translation + uniform3(random, 0.1 * unit)};
    const Vector3 from = X0.translation + uniform3(random, extent), d = uniform3(random, extent);
    const Vector3 travel = d - (X1.translation - X0.translation);
    const int parts = sweep_parts(angle_between(X0.rotation, X1.rotation), travel.norm(), extent, radius);
    const auto seen = [&](double s) {
      return (interpolate(X0, X1, s).inverse() * Point<World>{from + s * d}).m;
    };
    const double allowed = std::max(kBend * radius, kBendOfMesh * extent);
    for (int i = 0; i < 4; ++i) {
      const auto part = static_cast<double>(random.below(static_cast<std::uint64_t>(parts)));
      const Vector3 a = seen(part / parts), b = seen((part + 1) / parts);
      for (int j = 1; j < 8; ++j) {
        const Vector3 p = seen((part + j / 8.0) / parts);
        if (p.norm() > extent + radius) continue;  // cannot touch there
        const double bend = (p - (a + j / 8.0 * (b - a))).norm();
        ASSERT_LE(bend, allowed * (1 + 1e-9)) << "case " << k;
        worst = std::max(worst, bend / allowed);
      }
    }
  }
  EXPECT_GT(worst, 0.2) << "the bound is not idle";
}

TEST(SweepExact, AHalfTurnWithinAStepIsFollowed) {
  // A blade swung half a turn round a far hilt meets the ball on its way; both its ends are nowhere near.
  auto blade = scene::box_mesh({0.3, -0.002, -0.02}, {0.5, 0.002, 0.02});
  const CollisionMesh mesh(blade);
  const Pose<World, Bat> X0{so3_exp(Vector3(0, 0, -1.5)), Vector3::Zero()};
  const Pose<World, Bat> X1{so3_exp(Vector3(0, 0, 1.5)), Vector3::Zero()};
  const Vector3 ball(0.4, 0.0, 0.0);
  const auto hit = sweep_moving(mesh, X0, X1, ball, ball, 0.02);
  ASSERT_TRUE(hit);
  // Touched by the flat side when it is 22 mm off at a lever of 0.4 m; the seen arc bends 0.1 mm at most.
  const double angle = std::asin(0.022 / 0.4);
  EXPECT_NEAR(hit->fraction, (1.5 - angle) / 3.0, 1.1e-4 / 0.4 / 3.0);
  EXPECT_GT(hit->normal.y(), 0.99);
}

TEST(SweepExact, PathsThatAreNotFiniteTouchNothing) {
  const CollisionMesh mesh(scene::box_mesh({-1, -1, -1}, {1, 1, 1}));
  const double nan = std::nan(""), endless = HUGE_VAL;
  EXPECT_FALSE(mesh.sweep({0, nan, 0}, {0, 0, 0}, 0.02));
  EXPECT_FALSE(mesh.sweep({0, 2, 0}, {0, nan, 0}, 0.02));
  EXPECT_FALSE(mesh.sweep({0, 2, 0}, {0, -endless, 0}, 0.02));
  EXPECT_FALSE(mesh.sweep({0, 2, 0}, {0, 0, 0}, nan));
  EXPECT_FALSE(mesh.ray({0, 2, 0}, {nan, 0, 0}));
}

}  // namespace
}  // namespace palpate::physics
