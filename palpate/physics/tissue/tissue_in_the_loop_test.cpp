// A stylus in the sampled loop with a soft body, whose forces come a tick late.
#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/physics/tissue/driven_law_for_tests.h"
#include "palpate/physics/tissue/tissue_plant_for_tests.h"

namespace palpate::physics::tissue {
namespace {

// Speed at which it leaves over that at which it came.
struct Bounce {
  bool left = false;
  double ratio = 0.0;
  int lost = 0;
  double created_j = 0.0;
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
      return {true, stylus.velocity.norm() / velocity.norm(), touch.lost, touch.created_j};
  }
  return {false, 0.0, law.newest().lost, law.newest().created_j};
}

TEST(TissueInTheLoop, AFreeStylusNeverLeavesFasterThanItCame) {
  for (const TipField* field : {&soft_field(), &stiff_field(), &nodule_field()})
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

// Beside the middle too, where what is hard pushes aside.
TEST(TissueInTheLoop, AFreeStylusThrownAboveSomethingHardNeverLeavesFasterThanItCame) {
  const auto tangent = [](const Vector3& place) {
    return (nodule_field().at(place - Vector3(0, 0, 1e-5)).force.z() - nodule_field().at(place).force.z()) /
           1e-5;
  };
  EXPECT_GT(tangent(over(0.00595)), 0.97 * kMostTangent_n_m);
  EXPECT_LT(tangent(over(0.00595, 0.03)), 0.6 * kMostTangent_n_m);
  for (const double aside : {0.0, 0.004, 0.008, 0.012})
    for (const double speed : {0.05, 0.1, 0.2, 0.4, 0.7, 1.0})
      for (int phase = 0; phase < 8; ++phase) {
        const Vector3 velocity = speed * Vector3(0.2 * (phase % 5 - 2), 0.1 * (phase % 3), -1.0).normalized();
        const Bounce b =
            bounce(nodule_field(), {}, over(-0.003 - 1.3e-4 * speed * phase, 0.003 + aside), velocity, 3e-5);
        EXPECT_LE(b.ratio, 1.0) << speed << " m/s, " << aside << " m aside, lost " << b.lost;
        EXPECT_TRUE(b.left) << speed << " m/s, " << aside << " m aside, lost " << b.lost;
      }
}

// Without damping and without the account the conservative force alone throws it back faster: the test can tell.
TEST(TissueInTheLoop, AConservativeForceAloneThrowsItBackFaster) {
  TissueSettings bare;
  bare.dissipation.damping_n_s_m = 0.0;
  bare.passivity_damping_n_s_m = 0.0;
  const Bounce thrown = bounce(stiff_field(), bare, over(-0.003), {0, 0, -0.1}, 3e-5);
  EXPECT_GT(thrown.ratio, 1.1);
  const double gained = 0.5 * PlantForTests{}.mass * 0.1 * 0.1 * (thrown.ratio * thrown.ratio - 1.0);
  EXPECT_GT(thrown.created_j, 0.9 * gained);
  EXPECT_LT(thrown.created_j, 2.0 * gained);
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
  for (const TipField* field : {&soft_field(), &stiff_field(), &nodule_field()})
    for (const double mass : {0.075, 0.225})
      for (const double friction : {0.0, 0.4}) {
        TissueSettings settings;
        settings.dissipation.friction = friction;
        PlantForTests stylus;
        stylus.mass = mass;
        stylus.damping = 0.2;
        stylus.push = 0.5 * field->at(over(0.004)).force.z() * -Vector3::UnitZ();
        // Where nothing holds it, it glides off what is hard, as it should.
        if (field != &nodule_field() || friction > 0.0) {
          EXPECT_LT(swing_after(*field, settings, stylus), 1e-4) << mass << " pushed, " << friction;
        }
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

}  // namespace
}  // namespace palpate::physics::tissue
