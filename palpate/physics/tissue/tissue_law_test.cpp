#include "palpate/physics/tissue/tissue_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "palpate/math/random_vector.h"
#include "palpate/physics/tissue/driven_law_for_tests.h"
#include "palpate/physics/tissue/two_contacts.h"
#include "tests/allocation_count.h"

namespace palpate::physics::tissue {
namespace {

TEST(TissueLaw, PressedSlowlyItPushesAsTheFieldSays) {
  DrivenLaw driven(soft_field());
  driven.at(over(-0.002));
  driven.go(over(0.004));
  Vector3 force;
  for (int i = 0; i < 50; ++i) force = driven.at(over(0.004));
  EXPECT_LT((force - soft_field().at(over(0.004)).force).norm(), 1e-9);
  EXPECT_EQ(driven.law.newest().touches, 1);
  EXPECT_EQ(driven.law.newest().static_force, soft_field().at(over(0.004)).force);
}

TEST(TissueLaw, InAMovedAndTurnedBodyItPushesTheSameTurned) {
  const Pose<World, Body> moved{so3_exp({0.4, -0.8, 0.3}), {0.3, -1.2, 0.5}};
  TissueLaw law(soft_field(), {}, moved);
  scene::TipState tip;
  Vector3 force;
  for (int i = 0; i < 500; ++i) {
    tip.X_world_tip.translation = (moved * Point<Body>{over(std::min(0.004, -0.001 + 1e-4 * i))}).m;
    force = law.force(tip, 1e-3);
  }
  const Vector3 expected = moved.rotation * soft_field().at(over(0.004)).force;
  EXPECT_LT((force - expected).norm(), 1e-9);
  EXPECT_LT((law.newest().static_force - expected).norm(), 1e-9);
}

// Found inside within one tick: the account misses what is stored, and damps. By whose motion it got there is all one.
TEST(TissueLaw, WhatIsDampedIsTheMotionByTheBodyWhateverTheBodysOwn) {
  const Vector3 way(0.02, -0.01, -0.05);
  DrivenLaw at_rest(soft_field());
  at_rest.at(over(-0.001));
  const Vector3 expected = at_rest.at(over(0.003), way);
  EXPECT_GT(at_rest.law.newest().damping, 0.1);
  const Pose<World, Body> moved{so3_exp({0.4, -0.8, 0.3}), {0.3, -1.2, 0.5}};
  BodyMotion motion;
  motion.X_world_body = moved;
  motion.velocity = {0.2, 0.1, -0.3};
  motion.spin = {1.0, -2.0, 3.0};
  DrivenLaw driven(soft_field());
  motion.time = driven.tip.time + Duration(1'000'000);
  driven.law.move_body(motion);
  driven.at((moved * Point<Body>{over(-0.001)}).m);
  motion.time += Duration(1'000'000);
  driven.law.move_body(motion);
  const Vector3 lever = moved.rotation * over(0.003);
  const Vector3 force = driven.at((moved * Point<Body>{over(0.003)}).m,
                                  motion.velocity + motion.spin.cross(lever) + moved.rotation * way);
  EXPECT_LT((force - moved.rotation * expected).norm(), 1e-9);
}

TEST(TissueLaw, TheAccountsDampingDoesNotMakeTheContactStick) {
  DrivenLaw driven(soft_field(), {.dissipation = {.damping_n_s_m = 0.0}});
  driven.at(over(-0.001));
  const Vector3 force = driven.at(over(0.0005), {0.0, 0.0, 0.05});
  EXPECT_GT(0.05 * driven.law.newest().damping, driven.law.newest().static_force.z());
  EXPECT_NEAR(force.z(), 0.0, 1e-12);
}

TEST(TissueLaw, BetweenStepsOfPhysicsTheBodyIsCarriedOnAndNotForLong) {
  TissueLaw law(soft_field(), {}, kAtRest);
  BodyMotion motion;
  motion.time = Instant<PhysicsClock>{std::chrono::seconds(1)};
  motion.velocity = {0.1, 0.0, 0.05};
  motion.spin = {0.0, 2.0, 0.0};
  law.move_body(motion);
  scene::TipState tip;
  tip.time = motion.time;
  for (int i = 0; i <= 35; ++i) {
    tip.X_world_tip.translation = over(-0.0005 + 1e-4 * i, 0.02);
    law.force(tip, 1e-3);
  }
  for (const int later : {0, 1, 2, 3, 50}) {
    tip.time = motion.time + std::chrono::milliseconds(later);
    law.force(tip, 1e-3);
    const double carried = 1e-3 * std::min(later, 3);
    const Pose<World, Body> X{so3_exp(carried * motion.spin), carried * motion.velocity};
    const Vector3 p = (X.inverse() * Point<World>{tip.X_world_tip.translation}).m;
    const Vector3 expected = X.rotation * soft_field().at(p).force;
    EXPECT_GT(expected.norm(), 0.05);
    EXPECT_LT((law.newest().static_force - expected).norm(), 1e-9) << later;
  }
}

// A body that comes up against a tip at rest is what a tip is that comes down on a body at rest.
TEST(TissueLaw, ABodyThatMovesIsPressedByATipAtRest) {
  TissueLaw law(soft_field(), {}, kAtRest);
  DrivenLaw other(soft_field());
  scene::TipState tip;
  tip.X_world_tip.translation = over(-0.001);
  BodyMotion motion;
  motion.velocity = {0, 0, 0.02};
  for (int i = 0; i < 200; ++i) {
    tip.time = motion.time = Instant<PhysicsClock>{Duration(1'000'000 * i)};
    motion.X_world_body.translation = {0, 0, 2e-5 * i};
    law.move_body(motion);
    const Vector3 force = law.force(tip, 1e-3);
    const Vector3 expected = other.at(over(-0.001 + 2e-5 * i), {0, 0, i == 0 ? 0.0 : -0.02});
    ASSERT_LT((force - expected).norm(), 1e-9) << i;
  }
  EXPECT_GT(law.newest().contact.depth, 0.002);
}

TEST(TissueLaw, ABodyThatIsPausedIsNotFelt) {
  DrivenLaw driven(soft_field());
  driven.at(over(-0.001));
  driven.go(over(0.003));
  BodyMotion motion;
  motion.paused = true;
  driven.law.move_body(motion);
  EXPECT_EQ(driven.at(over(0.003)), Vector3::Zero());
  motion.paused = false;
  driven.law.move_body(motion);
  EXPECT_EQ(driven.at(over(0.003)), Vector3::Zero()) << "it has not been outside since";
  driven.at(over(-0.001));
  EXPECT_GT(driven.go(over(0.003)).z(), 0.0);
}

// Prescribed motion at up to 0.1 m/s over the flat, over an edge and in and out of contact: only what the tangent
// explains, and 0.02 N.
TEST(TissueLaw, TheStaticForceStepsNoFurtherThanItsTangentSays) {
  const TipField& field = stiff_field();
  DrivenLaw driven(field);
  const auto path = [](double t) {
    return over(0.0025 + 0.0028 * std::sin(7.1 * t - 1.8), 0.055 * std::sin(0.9 * t),
                0.03 * std::sin(1.3 * t + 1.0));
  };
  Vector3 before = Vector3::Zero();
  double worst = -1.0, strongest = 0.0;
  int pressed = 0, touches = 0;
  for (int i = 1; i < 100'000; ++i) {
    const Vector3 place = path(1e-3 * i), way = place - path(1e-3 * (i - 1));
    driven.at(place, way / 1e-3);
    const TissueTouch& touch = driven.law.newest();
    worst = std::max(worst, (touch.static_force - before).norm() - field.facts().stiffest_n_m * way.norm());
    before = touch.static_force;
    strongest = std::max(strongest, before.norm());
    pressed += touch.contact.depth > 0.0;
    touches = touch.touches;
  }
  EXPECT_GT(pressed, 50'000);
  EXPECT_GT(touches, 50);
  EXPECT_EQ(driven.law.newest().lost, 0);
  EXPECT_GT(strongest, 1.0);
  EXPECT_LT(worst, 0.02);
}

// A finger beside the tip: what it dents away is not felt, and what both hold is the shared energy.
TEST(TissueLaw, AFingerBesideItTakesForceAwayAndIsPushedItself) {
  const MutualCompliance mutual =
      half_space_compliance(over(0.004), over(0.005, 0.023), 6000.0, 0.45, kTipRadius);
  const TwoForces expected =
      two_contacts(soft_field(), over(0.004), soft_field(), over(0.005, 0.023), mutual);
  DrivenLaw driven(soft_field(), {.finger = &soft_field(), .young_pa = 6000.0});
  driven.at(over(-0.001));
  driven.go(over(0.004));
  const double alone = driven.at(over(0.004)).z();
  BodyMotion motion;
  motion.finger_there = true;
  Vector3 force;
  for (int i = 0; i <= 300; ++i) {
    motion.finger = over(std::min(0.005, -0.001 + 3e-5 * i), 0.023);
    driven.law.move_body(motion);
    force = driven.at(over(0.004));
  }
  EXPECT_LT(force.z(), 0.97 * alone);
  EXPECT_LT((force - expected.first).norm(), 1e-9);
  EXPECT_LT((driven.law.newest().finger_force - expected.second).norm(), 1e-9);
  for (int i = 300; i >= 0; --i) {
    motion.finger = over(std::min(0.005, -0.001 + 3e-5 * i), 0.023);
    driven.law.move_body(motion);
    driven.at(over(0.004), {1e-3, 0.0, 0.0});
  }
  EXPECT_EQ(driven.law.newest().damped_ticks, 0) << "what the finger brings in is not missing";
  motion.finger.x() = std::nan("");
  driven.law.move_body(motion);
  EXPECT_TRUE(driven.at(over(0.004)).allFinite());
}

TEST(TissueLaw, AFingerOnATurnedBodyIsPushedTheSameTurned) {
  const Pose<World, Body> turned{so3_exp({0.4, -0.8, 0.3}), {0.3, -1.2, 0.5}};
  const auto on_finger = [](const Pose<World, Body>& X_world_body) {
    DrivenLaw driven(soft_field(), {.finger = &soft_field()});
    BodyMotion motion;
    motion.X_world_body = X_world_body;
    motion.finger_there = true;
    motion.finger = over(0.005, 0.023);
    driven.law.move_body(motion);
    for (const double depth : {-0.001, 0.002, 0.004}) driven.at((X_world_body * Point<Body>{over(depth)}).m);
    return driven.law.newest().finger_force;
  };
  const Vector3 expected = turned.rotation * on_finger(kAtRest);
  EXPECT_GT(expected.norm(), 0.1);
  EXPECT_LT((on_finger(turned) - expected).norm(), 1e-9);
}

TEST(TissueLaw, PushedTooDeepItLetsGoEvenlyAndTakesHoldOutsideOnly) {
  DrivenLaw driven(soft_field());
  driven.at(over(-0.001));
  driven.go(over(0.0088), 1e-4);
  const double held = driven.law.newest().force.norm();
  EXPECT_GT(held, 0.3);
  double before = held;
  for (int i = 0; i < 400; ++i) {
    const Vector3 force = driven.at(over(0.0092 + 1e-5 * i));
    EXPECT_GE(force.z(), 0.0) << "never to the other side";
    EXPECT_LE(force.norm(), before + 1e-12);
    EXPECT_LE(before - force.norm(), 0.02 + 1e-9) << i;
    before = force.norm();
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_EQ(driven.law.newest().lost, 1);
  EXPECT_EQ(driven.go(over(0.004), 1e-4), Vector3::Zero());
  driven.go(over(-0.001), 1e-4);
  EXPECT_GT(driven.go(over(0.004), 1e-4).z(), 0.0);
}

TEST(TissueLaw, ABodyThatLeapsIsNotFeltNorOneThatTakesTheTipAlong) {
  for (const bool along : {false, true}) {
    DrivenLaw driven(soft_field());
    driven.at(over(-0.001));
    EXPECT_GT(driven.go(over(0.003)).z(), 0.0);
    BodyMotion motion;
    motion.X_world_body.translation = {0.03, 0.0, 0.0};
    driven.law.move_body(motion);
    EXPECT_EQ(driven.at(over(0.003) + (along ? Vector3(0.03, 0.0, 0.0) : Vector3(0.0, 0.0, 0.0))),
              Vector3::Zero())
        << along;
  }
}

TEST(TissueLaw, OfAContactThatIsOverNothingIsLeft) {
  const TissueSettings settings{.dissipation = {.relaxation_s = 0.1, .friction = 0.3}};
  DrivenLaw used(soft_field(), settings), fresh(soft_field(), settings);
  used.at(over(-0.001));
  used.go(over(0.004, 0.006), 1e-4);
  for (DrivenLaw* driven : {&used, &fresh}) {
    driven->at(over(-0.0005), {0.0, 0.0, 0.1});
    driven->at(over(0.002), {0.0, 0.0, -0.1});
    driven->at(over(0.0021), {0.0, 0.0, -0.1});
  }
  EXPECT_GT(fresh.law.newest().damping, 0.0);
  EXPECT_EQ(used.law.newest().force, fresh.law.newest().force);
  EXPECT_EQ(used.law.newest().damping, fresh.law.newest().damping);
}

TEST(TissueLaw, CountsAreThoseSinceTheReset) {
  DrivenLaw driven(soft_field(), {.dissipation = {.friction = 0.3}});
  driven.at(over(-0.001));
  driven.go(over(0.003));
  driven.go(over(0.003, 0.013));
  driven.go(over(0.003));
  TissueTouch touch = driven.law.newest();
  EXPECT_EQ(touch.touches, 1);
  EXPECT_EQ(touch.slips, 2) << "there and back";
  EXPECT_NEAR(touch.contact_s, 2.3, 0.005) << "3 mm and twice 10 mm at 10 mm/s";
  EXPECT_NEAR(touch.peak_n, touch.static_force.norm() * std::hypot(1.0, 0.3), 0.02);
  BodyMotion motion;
  motion.resets = 1;
  driven.law.move_body(motion);
  driven.at(over(0.003));
  touch = driven.law.newest();
  EXPECT_EQ(touch.touches + touch.slips + touch.lost + touch.damped_ticks, 0);
  EXPECT_NEAR(touch.contact_s, 0.001, 1e-12);
  EXPECT_EQ(touch.peak_n, touch.force.norm());
}

// A sheet of half the tip's size, pushed through at speeds from a crawl to 9 m/s, from both sides.
TEST(TissueLaw, PushedThroughASheetTheForceNeverTurnsToTheOtherSide) {
  const SoftForTests soft{.radius = 0.003};
  const Vector3 half(0.03, 0.03, 0.003);
  const TipField field = *block_for_tests(soft, half, 0.006);
  for (const double side : {1.0, -1.0})
    for (const double step : {1e-5, 1e-4, 1e-3, 2.3e-3, 5e-3, 9e-3})
      for (int phase = 0; phase < 10; ++phase) {
        DrivenLaw driven(field);
        bool through = false;
        for (double z = 0.012 + 0.1 * step * phase; z > -0.012 - step; z -= step) {
          const double force = side * driven.at({0.0, 0.001, side * z}, {0, 0, -side * step / 1e-3}).z();
          // Beyond the sheet and outside it again, whatever comes is a new contact; going away there is none.
          EXPECT_GE(force, 0.0) << side << " " << step << " " << z;
          through = through || z < -half.z() - soft.radius;
        }
        EXPECT_TRUE(through);
      }
}

TEST(TissueLaw, ATipThatLeapsOrIsNoNumberHasNoForceUntilItHasBeenOutside) {
  for (const Vector3& bad :
       {Vector3(0.1, 0.0, 0.3), Vector3(std::nan(""), 0.0, 0.0),
        Vector3(0.0, std::numeric_limits<double>::infinity(), 0.0), Vector3(1e200, 0.0, 0.0)}) {
    DrivenLaw driven(soft_field());
    driven.at(over(-0.001));
    driven.go(over(0.003));
    EXPECT_EQ(driven.at(bad), Vector3::Zero());
    EXPECT_EQ(driven.at(over(0.003)), Vector3::Zero()) << "put there, not moved";
    EXPECT_EQ(driven.at(over(0.0031)), Vector3::Zero());
    driven.at(over(-0.001));
    EXPECT_GT(driven.go(over(0.003)).z(), 0.0);
  }
}

TEST(TissueLaw, WhatCannotBeRenderedIsRefusedInWords) {
  TipFieldFacts facts = soft_field().facts();
  facts.stiffest_n_m = 701.0;
  const TipField stiff(facts, soft_field().fields());
  EXPECT_NE(TissueLaw::renders(stiff).error().message.find("701 N/m stiff"), std::string::npos);
  EXPECT_THROW(TissueLaw(stiff, {}, kAtRest), std::invalid_argument);
  facts = soft_field().facts();
  facts.strongest_n = 21.0;
  EXPECT_THROW(TissueLaw(TipField(facts, soft_field().fields()), {}, kAtRest), std::invalid_argument);
  EXPECT_THROW(TissueLaw(soft_field(), {.passivity_damping_n_s_m = -1.0}, kAtRest), std::invalid_argument);
  EXPECT_NO_THROW(TissueLaw(soft_field(), {}, kAtRest));
}

// A field that is 170 times as strong as its facts say.
TEST(TissueLaw, WhateverTheFieldSaysTheForceStaysWithinItsBound) {
  const SplineFields<2>& fields = soft_field().fields();
  std::vector<float> coefficients = fields.coefficients();
  for (std::size_t i = 1; i < coefficients.size(); i += 2) coefficients[i] *= 170.0f;
  const TipField strong(soft_field().facts(), SplineFields<2>(fields.lattice(), coefficients));
  DrivenLaw driven(strong);
  driven.at(over(-0.001));
  ASSERT_GT(strong.at(over(0.004)).force.norm(), 1.2 * TissueLaw::kBound_n);
  EXPECT_NEAR(driven.go(over(0.004)).norm(), TissueLaw::kBound_n, 1e-9);
}

TEST(TissueLaw, ATickOfTheLawAllocatesNothing) {
  DrivenLaw driven(soft_field(), {.dissipation = {.friction = 0.3}});
  driven.at(over(-0.001));
  const std::size_t before = allocations();
  for (int i = 0; i < 1000; ++i) driven.at(over(1e-5 * i, 1e-5 * i), {0.01, 0, -0.01});
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_EQ(driven.law.newest().lost, 1);
}

}  // namespace
}  // namespace palpate::physics::tissue
