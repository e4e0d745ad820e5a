#include "palpate/physics/tissue/energy_account.h"

#include <gtest/gtest.h>

namespace palpate::physics::tissue {
namespace {

TEST(EnergyAccount, CountsTheWorkAgainstTheLastForceAndTheOneBeforeAndTakesTheLess) {
  EnergyAccount account(4.0);
  account.give({0.0, 0.0, 1.0});
  account.give({0.0, 0.0, 2.0});
  account.moved({0.0, 0.0, -1e-3});  // 2 mJ, a tick late 1 mJ
  EXPECT_EQ(account.created(), 0.0);
  EXPECT_NEAR(account.damping(1.5e-3, {0.0, 0.0, 1.0}, 1e-3), 0.499, 1e-9) << "but for a microjoule";
  EXPECT_NEAR(account.missing(), 0.499e-3, 1e-12);
  EXPECT_EQ(account.damping(1.5e-3, {0.0, 0.0, 0.1}, 1e-3), 4.0) << "at most";
  EXPECT_EQ(account.damping(1.5e-3, {0.0, 0.0, 0.0}, 1e-3), 0.0) << "at rest nothing is taken";
  EXPECT_EQ(account.damping(1.0e-3, {0.0, 0.0, 1.0}, 1e-3), 0.0) << "nothing is missing";
  account.credit(0.5e-3);
  EXPECT_EQ(account.damping(1.5e-3, {0.0, 0.0, 1.0}, 1e-3), 0.0) << "others have put it in";
  account.moved({0.0, 0.0, 4e-3});
  EXPECT_NEAR(account.created(), 8e-3 - 1.5e-3, 1e-12);
  account.reset();
  EXPECT_EQ(account.created(), 0.0);
  account.moved({0.0, 0.0, 1.0});
  EXPECT_EQ(account.damping(0.0, {0.0, 0.0, 1.0}, 1e-3), 0.0) << "no force is remembered";
}

// What was dissipated in one press does not pay for the next.
TEST(EnergyAccount, KeepsNoCredit) {
  EnergyAccount account(4.0);
  account.give({0.0, 0.0, 1.0});
  account.give({0.0, 0.0, 1.0});
  account.moved({0.0, 0.0, -0.1});
  EXPECT_EQ(account.damping(1e-3, {0.0, 0.0, 1.0}, 1e-3), 0.0);
  account.moved({0.0, 0.0, 1e-3});
  EXPECT_NEAR(account.damping(1e-3, {0.0, 0.0, 1.0}, 1e-3), 0.997, 1e-9) << "but for three microjoules";
}

}  // namespace
}  // namespace palpate::physics::tissue
