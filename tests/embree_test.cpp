// Our rays beside Embree's on the same mesh. Embree computes in float, which is where the tolerance comes
// from.
#include "tests/embree_rays.h"

#include <gtest/gtest.h>

#include "palpate/math/random_vector.h"
#include "palpate/physics/sweep.h"

namespace palpate {
namespace {

TEST(Embree, SeesWhatOurRaysSee) {
  Random random(1, "embree");
  scene::TriangleMesh mesh;  // 100,352 triangles over 2 m x 2 m, coordinates that floats hold
  constexpr std::uint32_t n = 224;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j)
      mesh.vertices.push_back(Vector3(2.0 * j / n - 1.0, random.uniform(-0.004, 0.004), 2.0 * i / n - 1.0)
                                  .cast<float>()
                                  .cast<double>());
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  const EmbreeRays embree(mesh);
  const physics::CollisionMesh ours(mesh);
  constexpr int kRays = 50000;
  int hits = 0, apart = 0;
  for (int k = 0; k < kRays; ++k) {
    const Vector3 from = uniform3(random, 1.2).cwiseProduct(Vector3(1, 0.1, 1)).cast<float>().cast<double>();
    const Vector3 d = (uniform3(random, 0.5).cwiseProduct(Vector3(1, 0.6, 1))).cast<float>().cast<double>();
    const auto theirs = embree.first(from, d);
    const auto mine = ours.ray(from, from + d);
    hits += mine.has_value();
    // Floats place a crossing to 1e-7 m times one over the sine of the angle; a ray that just grazes a ridge,
    // or ends on the surface, may go on to the next for one of the two.
    const bool same = mine.has_value() == theirs.has_value() &&
                      (!mine || std::abs(mine->fraction - *theirs) * d.norm() < 2e-5);
    apart += !same;
  }
  EXPECT_GT(hits, kRays / 5);
  EXPECT_LT(hits, 4 * kRays / 5);
  EXPECT_LE(apart, kRays / 5000);
}

}  // namespace
}  // namespace palpate
