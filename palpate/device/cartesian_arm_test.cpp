// The Cartesian arm: its correction, its kinematics, its file.
#include <gtest/gtest.h>

#include <set>

#include "palpate/core/random.h"
#include "palpate/core/toml.h"
#include "palpate/device/arm_kinematics.h"
#include "palpate/device/arm_model_file.h"
#include "palpate/math/random_vector.h"

namespace palpate::device {
namespace {

PlaceCorrection some_correction(Random& random) {
  PlaceCorrection correction{{0.01, -0.17, 0.16}, 0.08, {}};
  for (double& term : correction.terms) term = random.normal(0.003);
  return correction;
}

ArmModel some_arm(Random& random) {
  ArmModel model;
  model.kind = ArmModel::Kind::cartesian;
  model.name = "delta";
  model.places = {{{-0.07, 0.09}, {-0.25, -0.09}, {0.08, 0.24}}};
  model.correction = some_correction(random);
  return model;
}

Vector3 somewhere(Random& random) { return Vector3(0.01, -0.17, 0.16) + normal3(random, 0.05); }

// The polynomial written out term by term, by its names.
TEST(PlaceCorrection, IsTheSumOfItsNamedTerms) {
  Random random(1, "place correction/terms");
  const auto correction = some_correction(random);
  const auto& names = PlaceCorrection::names();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), 24u);
  for (int n = 0; n < 20; ++n) {
    const Vector3 stated = somewhere(random), u = (stated - correction.centre) / correction.reach;
    const auto axis = [](char letter) { return static_cast<Eigen::Index>(letter - 'x'); };
    Vector3 sum = Vector3::Zero();
    for (int k = 0; k < PlaceCorrection::kTerms; ++k) {
      const std::string& name = names[static_cast<std::size_t>(k)];
      const double c = correction.terms[k];
      if (name.starts_with("strain_")) {
        const auto i = axis(name[7]), j = axis(name[8]);
        sum[i] += c * u[j];
        if (i != j) sum[j] += c * u[i];
      } else {
        ASSERT_TRUE(name.starts_with("bend_"));
        sum[axis(name[8])] += c * u[axis(name[5])] * u[axis(name[6])];
      }
    }
    EXPECT_LT((correction.at(stated) - sum).norm(), 1e-17);
  }
}

TEST(PlaceCorrection, ItsSlopeAgreesWithFiniteDifferences) {
  Random random(2, "place correction/slope");
  const auto correction = some_correction(random);
  for (int n = 0; n < 20; ++n) {
    const Vector3 stated = somewhere(random);
    const Matrix3 slope = correction.slope(stated);
    constexpr double kH = 1e-5;
    for (int i = 0; i < 3; ++i) {
      const Vector3 step = kH * Vector3::Unit(i);
      const Vector3 numeric = (correction.at(stated + step) - correction.at(stated - step)) / (2.0 * kH);
      EXPECT_LT((slope.col(i) - numeric).norm(), 1e-11);
    }
  }
}

// What the base's place and turn would do is not among the terms: near the centre nothing is shifted or turned.
TEST(PlaceCorrection, HasNoPartOfAMotionOfTheBase) {
  Random random(3, "place correction/motion");
  const auto correction = some_correction(random);
  EXPECT_EQ(correction.at(correction.centre), Vector3::Zero());
  const Matrix3 slope = correction.slope(correction.centre);
  EXPECT_LT((slope - slope.transpose()).norm(), 1e-16);
}

TEST(CartesianArm, ItsTipIsTheCorrectedPlaceAndItsJacobianFollows) {
  Random random(4, "cartesian arm/tip");
  const ArmModel model = some_arm(random);
  ASSERT_TRUE(check_runnable(model));
  const auto arm = make_kinematics(model);
  EXPECT_EQ(arm->joint_count(), 3);
  EXPECT_EQ(arm->range(1).low, -0.25);
  for (int n = 0; n < 20; ++n) {
    const Vector3 stated = somewhere(random), gimbal = normal3(random, 0.4);
    const Vector3 tip = stated + model.correction.at(stated);
    EXPECT_LT((arm_tip(model, stated).m - tip).norm(), 1e-16);
    ArmJacobian J;
    EXPECT_LT((arm_tip(model, stated, J).m - tip).norm(), 1e-16);
    const auto both = arm->pose_and_jacobian(stated, gimbal);
    EXPECT_EQ(both.pose.translation, arm->pose(stated, gimbal).translation);
    EXPECT_EQ(both.jacobian, arm->jacobian(stated));
    EXPECT_LT((both.pose.translation - tip).norm(), 1e-16);
    EXPECT_LT((Matrix3(both.jacobian) - Matrix3(J.theta)).norm(), 1e-15);
    EXPECT_LT((J.correction * model.correction.terms - model.correction.at(stated)).norm(), 1e-16);
    constexpr double kH = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const Vector3 step = kH * Vector3::Unit(i);
      const Vector3 numeric =
          (arm_tip(model, stated + step).m - arm_tip(model, stated - step).m) / (2.0 * kH);
      EXPECT_LT((both.jacobian.col(i) - numeric).norm(), 1e-9);
    }
    EXPECT_GT(manipulability(both.jacobian), arm->least_manipulability());
  }
}

TEST(CartesianArm, AnglesOfATurnAreThoseThatMadeIt) {
  Random random(6, "cartesian arm/gimbal");
  for (int n = 0; n < 100; ++n) {
    const Vector3 gimbal(random.uniform(-3.0, 3.0), random.uniform(-1.5, 1.5), random.uniform(-3.0, 3.0));
    EXPECT_LT((gimbal_angles(gimbal_turn(gimbal)) - gimbal).norm(), 1e-12);
  }
  EXPECT_TRUE(gimbal_angles(gimbal_turn({0.3, 1.5707963267948966, 0.2})).allFinite()) << "upright";
}

Expected<ArmModel> parsed(const std::string& text) { return parse_arm_model(text, "arm.toml"); }

TEST(CartesianArm, ItsFileComesBack) {
  Random random(5, "cartesian arm/file");
  const ArmModel model = some_arm(random);
  const auto again = parsed("name = \"delta\"\n" + cartesian_text(model));
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(again->kind, ArmModel::Kind::cartesian);
  EXPECT_EQ(again->name, "delta");
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(again->places[i].low, model.places[i].low, 1e-16);
    EXPECT_NEAR(again->places[i].high, model.places[i].high, 1e-16);
  }
  EXPECT_LT((again->correction.terms - model.correction.terms).norm(), 1e-17);
  EXPECT_LT((again->correction.centre - Vector3(0.01, -0.17, 0.16)).norm(), 1e-15) << "of the range";
  EXPECT_NEAR(again->correction.reach, 0.08, 1e-15);
  ArmModel plain = model;
  plain.correction.terms.setZero();
  EXPECT_EQ(cartesian_text(plain).find("correction_mm"), std::string::npos);
}

TEST(CartesianArm, AFileThatIsNoneIsRefusedWithItsLine) {
  const auto refuses = [](const std::string& text, const std::string& words) {
    const auto model = parsed(text);
    ASSERT_FALSE(model.has_value()) << text;
    EXPECT_EQ(model.error().kind, Error::Kind::wrong_use);
    EXPECT_NE(model.error().message.find(words), std::string::npos) << model.error().message;
  };
  refuses("type = 'cartesian'\n", "range_mm");
  refuses("type = 'cartesian'\nrange_mm = [[0, 1], [0, 1]]\n", "arm.toml:2: range_mm");
  refuses("type = 'cartesian'\nrange_mm = [[0, 1], [0, 1], [1, 0]]\n", "the lower end first is expected");
  refuses("type = 'cartesian'\nrange_mm = [[0, 1], [0, 1], [0, 1]]\ncorrection_mm = [1, 2]\n",
          "arm.toml:3: correction_mm");
  refuses("type = 'cartesian'\nrange_mm = [[0, 1], [0, 1], [0, 1]]\n[[joint]]\na_mm = 1\n", "joint");
}

}  // namespace
}  // namespace palpate::device
