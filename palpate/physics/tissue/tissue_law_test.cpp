#include "palpate/physics/tissue/tissue_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpate/math/random_vector.h"
#include "palpate/physics/tissue/tissue_for_tests.h"
#include "palpate/physics/tissue/tissue_plant_for_tests.h"
#include "palpate/physics/tissue/two_contacts.h"
#include "tests/allocation_count.h"

namespace palpate::physics::tissue {
namespace {

constexpr double kTop = 0.02, kTipRadius = 0.008;
const Pose<World, Body> kAtRest;

const TipField& soft_field() {
  static const TipField field = *block_for_tests({});
  return field;
}
// As stiff as is allowed; the box's corners, which are stiffer by the lattice, set that.
const TipField& stiff_field() {
  static const TipField field = [] {
    const double rough = soft_field().facts().stiffest_n_m;
    return *block_for_tests({.young = 6000.0 * 0.999 * kMostTangent_n_m / rough});
  }();
  return field;
}

Vector3 over(double depth, double x = 0.003, double y = 0.002) { return {x, y, kTop + kTipRadius - depth}; }

// What the law has been told last, and its static force there.
struct DrivenLaw {
  explicit DrivenLaw(const TipField& field, const TissueSettings& settings = {})
      : law(field, settings, kAtRest) {}
  Vector3 at(const Vector3& place, const Vector3& velocity = Vector3::Zero()) {
    tip.time += Duration(1'000'000);
    tip.X_world_tip.translation = place;
    tip.velocity = velocity;
    return law.force(tip, 1e-3);
  }
  // In a straight line, so far a tick.
  Vector3 go(const Vector3& to, double step = 1e-5) {
    const Vector3 from = tip.X_world_tip.translation;
    const int ticks = std::max(1, static_cast<int>(std::ceil((to - from).norm() / step)));
    Vector3 force;
    for (int i = 1; i <= ticks; ++i) force = at(from + (to - from) * i / ticks, (to - from) / ticks / 1e-3);
    return force;
  }
  TissueLaw law;
  scene::TipState tip;
};

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
  EXPECT_LT((force - moved.rotation * soft_field().at(over(0.004)).force).norm(), 1e-9);
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
  EXPECT_EQ(driven.law.newest().damped_ticks, 0) << "what the finger brings in is not missing";
  motion.finger.x() = std::nan("");
  driven.law.move_body(motion);
  EXPECT_TRUE(driven.at(over(0.004)).allFinite());
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
    if (i > 0) {
      EXPECT_LE(force.norm(), before + 1e-12);
      EXPECT_LE(before - force.norm(), 0.02 + 1e-9);
    }
    before = force.norm();
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_EQ(driven.law.newest().lost, 1);
  EXPECT_EQ(driven.go(over(0.004), 1e-4), Vector3::Zero());
  driven.go(over(-0.001), 1e-4);
  EXPECT_GT(driven.go(over(0.004), 1e-4).z(), 0.0);
}

// A sheet of half the tip's size, pushed through at speeds from a crawl to 5 m/s, from both sides.
TEST(TissueLaw, PushedThroughASheetTheForceNeverTurnsToTheOtherSide) {
  const SoftForTests soft{.radius = 0.003};
  const Vector3 half(0.03, 0.03, 0.003);
  const TipField field = *block_for_tests(soft, half, 0.006);
  for (const double side : {1.0, -1.0})
    for (const double step : {1e-5, 1e-4, 1e-3, 2.3e-3, 5e-3})
      for (int phase = 0; phase < 10; ++phase) {
        DrivenLaw driven(field);
        bool through = false;
        for (double z = 0.012 + 0.1 * step * phase; z > -0.012; z -= step) {
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

// --- in the sampled loop, a tick late

// Speed at which it leaves over that at which it came.
struct Bounce {
  bool left = false;
  double ratio = 0.0;
  int lost = 0;
};
Bounce bounce(const TipField& field, const TissueSettings& settings, const Vector3& from,
              const Vector3& velocity, double encoder) {
  TissueLaw law(field, settings, kAtRest);
  PlantForTests stylus;
  stylus.place = from;
  stylus.velocity = velocity;
  stylus.encoder = encoder;
  bool touched = false;
  for (int i = 0; i < 3000; ++i) {
    stylus.tick(law);
    const TissueTouch& touch = law.newest();
    touched = touched || touch.contact.depth > 0.0;
    const bool away = field.at(stylus.place).depth <= 0.0 && stylus.forceless();
    if (touched && away && touch.force.isZero(0.0) && i > 20)
      return {true, stylus.velocity.norm() / velocity.norm(), touch.lost};
  }
  return {false, 0.0, law.newest().lost};
}

TEST(TissueInTheLoop, AFreeStylusNeverLeavesFasterThanItCame) {
  for (const TipField* field : {&soft_field(), &stiff_field()})
    for (const double speed : {0.05, 0.1, 0.2, 0.4, 0.7, 1.0})
      for (const double encoder : {0.0, 3e-5})
        for (int phase = 0; phase < 8; ++phase) {
          const double slant = 0.4 * (phase % 3);
          const Vector3 velocity = speed * Vector3(slant, 0.0, -1.0).normalized();
          const Bounce b = bounce(*field, {}, over(-0.003 - 1.3e-4 * speed * phase), velocity, encoder);
          EXPECT_LE(b.ratio, 1.0) << speed << " m/s, " << encoder << " lost " << b.lost;
          EXPECT_TRUE(b.left) << speed << " m/s, " << encoder << " lost " << b.lost;
        }
}

// Without damping and without the account the conservative force alone throws it back faster: the test can tell.
TEST(TissueInTheLoop, AConservativeForceAloneThrowsItBackFaster) {
  TissueSettings bare;
  bare.dissipation.damping_n_s_m = 0.0;
  bare.passivity_damping_n_s_m = 0.0;
  EXPECT_GT(bounce(stiff_field(), bare, over(-0.003), {0, 0, -0.1}, 3e-5).ratio, 1.1);
  TissueSettings account = bare;
  account.passivity_damping_n_s_m = 4.0;
  const Bounce kept = bounce(stiff_field(), account, over(-0.003), {0, 0, -0.1}, 3e-5);
  EXPECT_TRUE(kept.left);
  EXPECT_LE(kept.ratio, 1.02) << "the account alone keeps it passive, to an encoder step";
}

// Swing, peak to peak, from one second after the press on, m.
double swing_after(const TipField& field, const TissueSettings& settings, PlantForTests stylus) {
  TissueLaw law(field, settings, kAtRest);
  stylus.place = over(-0.0005);
  double low = 1.0, high = -1.0;
  for (int i = 0; i < 2500; ++i) {
    stylus.tick(law);
    if (i < 1000) continue;
    low = std::min(low, stylus.place.z());
    high = std::max(high, stylus.place.z());
  }
  return high - low;
}

TEST(TissueInTheLoop, HeldLightlyItRestsWithinASecondOfBeingPressed) {
  for (const TipField* field : {&soft_field(), &stiff_field()})
    for (const double mass : {0.075, 0.225})
      for (const double friction : {0.0, 0.4}) {
        TissueSettings settings;
        settings.dissipation.friction = friction;
        PlantForTests stylus;
        stylus.mass = mass;
        stylus.damping = 0.2;
        stylus.push = 0.5 * field->at(over(0.004)).force.z() * -Vector3::UnitZ();
        EXPECT_LT(swing_after(*field, settings, stylus), 1e-4) << mass << " pushed, " << friction;
        stylus.push.setZero();
        stylus.stiffness = 250.0;
        stylus.target = over(0.004);
        EXPECT_LT(swing_after(*field, settings, stylus), 1e-4) << mass << " held, " << friction;
      }
}

TEST(TissueInTheLoop, ReleasedWhilePressedItLeavesWithNoMoreThanWasStored) {
  for (const TipField* field : {&soft_field(), &stiff_field()})
    for (const double depth : {0.002, 0.004, 0.0055}) {
      TissueLaw law(*field, {}, kAtRest);
      PlantForTests stylus;
      stylus.place = over(-0.0005);
      stylus.damping = 5.0;
      stylus.push = -field->at(over(depth)).force;
      for (int i = 0; i < 3000; ++i) stylus.tick(law);
      ASSERT_NEAR(law.newest().contact.depth, depth, 1e-4);
      stylus.push.setZero();
      stylus.damping = 0.0;
      for (int i = 0; i < 500 && field->at(stylus.place).depth > 0.0; ++i) stylus.tick(law);
      EXPECT_EQ(field->at(stylus.place).depth, 0.0);
      EXPECT_GT(stylus.velocity.z(), 0.0);
      EXPECT_LT(0.5 * stylus.mass * stylus.velocity.squaredNorm(), field->at(over(depth)).energy) << depth;
    }
}

TEST(TissueInTheLoop, WithoutViscosityAndAccountItBuzzes) {
  TissueSettings bare;
  bare.dissipation.damping_n_s_m = 0.0;
  bare.passivity_damping_n_s_m = 0.0;
  PlantForTests stylus;
  stylus.damping = 0.2;
  stylus.stiffness = 250.0;
  stylus.target = over(0.004);
  EXPECT_GT(swing_after(stiff_field(), bare, stylus), 1e-3);
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
