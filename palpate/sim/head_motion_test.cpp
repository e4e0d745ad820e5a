// The head's path when it is held still: it comes to rest smoothly, stays, and goes on from there.
#include "palpate/sim/head_motion.h"

#include <gtest/gtest.h>

namespace palpate::sim {
namespace {

HeadMotion reference_head() {
  config::WorldFile world = config::reference_world();
  world.head.turn_peak = 0.5;
  return {world, Vector3(0.3, 0.0, 0.3)};
}

double way(const HeadMotion& head, double from, double to) {
  const auto a = head.at(from), b = head.at(to);
  return (a.translation - b.translation).norm() + angle_between(a.rotation, b.rotation);
}

TEST(HeadMotion, HeldStillItComesToRestAndGoesOnFromThere) {
  HeadMotion head = reference_head();
  const HeadMotion free = reference_head();
  head.hold_still(true, 5.0);
  EXPECT_EQ(way(head, 4.0, 4.9), way(free, 4.0, 4.9)) << "what has gone by stays as it was";
  EXPECT_GT(way(head, 4.6, 5.0), 0.01);
  EXPECT_GT(way(head, 5.0, 5.2), 1e-3) << "not at once";
  EXPECT_EQ(way(head, 5.6, 9.0), 0.0);
  head.hold_still(true, 7.0);  // again: nothing new
  EXPECT_EQ(way(head, 5.6, 9.0), 0.0);
  head.hold_still(false, 9.0);
  EXPECT_EQ(way(head, 8.0, 9.0), 0.0);
  EXPECT_GT(way(head, 9.6, 10.4), 0.01);
  // From then on the same motion, later by what it stood still.
  const double later = 4.0;  // 5.0 to 9.0, half of each rest counted once
  for (double t = 9.6; t < 12.0; t += 0.1) {
    const auto held = head.at(t), as_if = free.at(t - later);
    EXPECT_LT((held.translation - as_if.translation).norm(), 1e-9) << t;
  }
}

TEST(HeadMotion, NeverMovesFasterForBeingHeld) {
  HeadMotion head = reference_head();
  const HeadMotion free = reference_head();
  double fastest = 0.0, fastest_free = 0.0;
  double changed = 0.3;
  for (double t = 0.0; t < 6.0; t += 0.001) {
    if (t >= changed) {  // also before it has come to rest
      head.hold_still(static_cast<int>(changed * 10.0) % 2 == 1, t);
      changed += 0.3;
    }
    fastest = std::max(fastest, way(head, t - 0.001, t));
    fastest_free = std::max(fastest_free, way(free, t - 0.001, t));
  }
  EXPECT_LT(fastest, 1.05 * fastest_free);
  EXPECT_GT(fastest, 0.0);
}

}  // namespace
}  // namespace palpate::sim
