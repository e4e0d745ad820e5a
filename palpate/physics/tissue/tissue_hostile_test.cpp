// Whatever comes in: tips that leap, are no numbers, go at 5 m/s, come from below, bodies that are moved and paused.
// What goes out is always a number within the bound; and what contacts give out in the loop has been put in.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "palpate/math/random_vector.h"
#include "palpate/physics/tissue/tissue_for_tests.h"
#include "palpate/physics/tissue/tissue_law.h"

namespace palpate::physics::tissue {
namespace {

double bad_number(Random& random) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::array<double, 9> bad{std::nan(""), kInfinity, -kInfinity, 1e308, -1e308,
                                  1e150,        1e6,       1e-310,     0.0};
  return bad[random.below(bad.size())];
}

void hostile(int ticks) {
  const SoftForTests soft{.young = young_for_tests(480.0, 0.006)};
  const auto field = block_for_tests(soft, {0.03, 0.03, 0.01}, 0.006, 0.008);
  ASSERT_TRUE(field.has_value()) << field.error().message;
  TissueLaw law(*field, {.dissipation = {.friction = 0.3}}, {});
  Random random(7, "tissue/hostile");
  scene::TipState tip;
  BodyMotion motion;
  Vector3 place(0, 0, 0.03), velocity = Vector3::Zero();
  int pressed = 0, from_below = 0;
  double largest = 0.0;
  for (int i = 0; i < ticks; ++i) {
    // Calm stretches, so that something is pressed when it happens; fast ones, of up to 5 m/s.
    const double most = (i / 2000) % 4 == 3 ? 5.0 : 0.3;
    velocity +=
        normal3(random, 0.05 * most) - 0.3 * (place.norm() > 0.035 ? 1.0 : 0.0) * most * place.normalized();
    if (velocity.norm() > most) velocity *= most / velocity.norm();
    place += 1e-3 * velocity;
    const bool wild = random.chance(0.01);
    if (wild && random.chance(0.3)) place = uniform3(random, 0.05);
    tip.time += Duration(1'000'000);
    tip.X_world_tip.translation = place;
    tip.velocity = velocity;
    double dt = 1e-3;
    if (wild) {
      const auto what = random.below(6);
      const auto axis = static_cast<Eigen::Index>(random.below(3));
      if (what == 0) tip.X_world_tip.translation[axis] = bad_number(random);
      if (what == 1) tip.velocity[axis] = bad_number(random);
      if (what == 2) dt = bad_number(random);
      if (what == 3) tip.time += seconds(random.uniform(-1.0, 1.0));
      if (what >= 4) {
        motion.time = tip.time;
        motion.X_world_body.translation = uniform3(random, 0.003);
        motion.velocity = uniform3(random, 0.05);
        motion.spin = uniform3(random, 0.5);
        motion.paused = random.chance(0.1);
        motion.resets += random.chance(0.1);
        law.move_body(motion);
      }
    }
    const Vector3 force = law.force(tip, dt);
    ASSERT_TRUE(force.allFinite()) << i;
    ASSERT_LE(force.norm(), law.force_bound()) << i;
    const TissueTouch& touch = law.newest();
    if (!tip.X_world_tip.translation.allFinite()) {
      ASSERT_EQ(force, Vector3::Zero()) << i;
    }
    largest = std::max(largest, force.norm());
    pressed += touch.contact.depth > 0.0;
    from_below += touch.contact.depth > 0.0 && place.z() < 0.0;
  }
  EXPECT_GT(pressed, ticks / 50);
  EXPECT_GT(from_below, ticks / 500);
  EXPECT_GT(law.newest().lost, 0);
  EXPECT_GT(largest, 1.0);
}

TEST(TissueHostile, AHundredThousandTicksNeverBreakABound) { hostile(100'000); }

TEST(TissueHostileStatistics, AMillionTicksNeverBreakABound) { hostile(1'000'000); }

}  // namespace
}  // namespace palpate::physics::tissue
