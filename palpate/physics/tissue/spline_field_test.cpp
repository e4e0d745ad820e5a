#include "palpate/physics/tissue/spline_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/math/random_vector.h"
#include "tests/allocation_count.h"

namespace palpate::physics::tissue {
namespace {

template <typename Function>
std::vector<double> values_of(const Lattice& lattice, Function&& f) {
  std::vector<double> values;
  for (int z = 0; z < lattice.count[2]; ++z)
    for (int y = 0; y < lattice.count[1]; ++y)
      for (int x = 0; x < lattice.count[0]; ++x) values.push_back(f(lattice.at(x, y, z)));
  return values;
}

double wave(const Vector3& p) {
  return std::sin(40.0 * p.x() + 1.0) * std::cos(30.0 * p.y()) + 8.0 * p.z() * p.z();
}
Vector3 wave_gradient(const Vector3& p) {
  return {40.0 * std::cos(40.0 * p.x() + 1.0) * std::cos(30.0 * p.y()),
          -30.0 * std::sin(40.0 * p.x() + 1.0) * std::sin(30.0 * p.y()), 16.0 * p.z()};
}

Lattice cube_of(int points, double side = 0.12) {
  return {Vector3(-0.5 * side, -0.5 * side, -0.5 * side), side / (points - 1), {points, points, points}};
}

SplineFields<1> spline_of(const Lattice& lattice) {
  return SplineFields<1>::through(lattice, {values_of(lattice, wave)});
}

TEST(SplineField, GoesThroughItsValues) {
  const Lattice lattice{{0.1, -0.2, 0.3}, 0.004, {9, 12, 7}};
  const auto spline = spline_of(lattice);
  const Vector3 middle = 0.5 * (lattice.at(0, 0, 0) + lattice.at(8, 11, 6));
  for (int z = 1; z <= 5; ++z)
    for (int y = 1; y <= 10; ++y)
      for (int x = 1; x <= 7; ++x) {
        const Vector3 p = lattice.at(x, y, z) + 1e-9 * (middle - lattice.at(x, y, z));
        ASSERT_TRUE(lattice.covers(p)) << x << ' ' << y << ' ' << z;
        EXPECT_NEAR(spline.sample(p)[0].value, wave(p), 2e-6) << "floats: 6e-8 of 8 each";
      }
}

TEST(SplineField, KeepsALinearFieldUpToItsEndsToTheRoundingOfFloats) {
  const Lattice lattice{{-0.01, 0.02, 0.0}, 0.002, {8, 8, 8}};
  const Vector3 slope(3.0, -2.0, 0.5);
  const auto spline =
      SplineFields<1>::through(lattice, {values_of(lattice, [&](const Vector3& p) { return slope.dot(p); })});
  Random random(1, "tissue/linear");
  for (int i = 0; i < 1000; ++i) {
    const Vector3 p = lattice.at(0, 0, 0) + 0.002 * (Vector3::Constant(3.5) + uniform3(random, 2.4));
    const FieldSample s = spline.sample(p)[0];
    EXPECT_NEAR(s.value, slope.dot(p), 1e-8);
    EXPECT_LT((s.gradient - slope).norm(), 1e-5);
  }
}

// Halving the spacing: the value's error falls by 16, the gradient's by 8.
TEST(SplineField, ConvergesAsACubicSplineDoes) {
  std::array<double, 2> value{}, slope{};
  for (std::size_t level = 0; level < 2; ++level) {
    const auto spline = spline_of(cube_of(level == 0 ? 33 : 65, 0.48));
    Random random(2, "tissue/order");
    for (int i = 0; i < 3000; ++i) {
      const Vector3 p = uniform3(random, 0.05);  // the ends' own error has died away there
      const FieldSample s = spline.sample(p)[0];
      value[level] = std::max(value[level], std::abs(s.value - wave(p)));
      slope[level] = std::max(slope[level], (s.gradient - wave_gradient(p)).norm());
    }
  }
  EXPECT_NEAR(value[0] / value[1], 16.0, 3.0);
  EXPECT_NEAR(slope[0] / slope[1], 8.0, 1.5);
  EXPECT_LT(value[1], 3e-4);
}

TEST(SplineField, ItsGradientIsThatOfItsValue) {
  const auto spline = spline_of(cube_of(21));
  Random random(3, "tissue/gradient");
  for (int i = 0; i < 500; ++i) {
    const Vector3 p = uniform3(random, 0.05);
    const FieldSample s = spline.sample(p)[0];
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Vector3 step = 1e-6 * Vector3::Unit(k);
      const double difference = (spline.sample(p + step)[0].value - spline.sample(p - step)[0].value) / 2e-6;
      EXPECT_NEAR(s.gradient[k], difference, 1e-6);
    }
  }
}

// The gradient of a random field, as rough as it can be, over the faces between cells.
TEST(SplineField, ItsGradientHasNoStepBetweenCells) {
  const Lattice lattice{{0, 0, 0}, 1.0, {9, 9, 9}};
  Random random(4, "tissue/steps");
  const auto spline = SplineFields<1>::through(
      lattice, {values_of(lattice, [&](const Vector3&) { return random.normal(); })});
  for (int i = 0; i < 500; ++i) {
    Vector3 p = Vector3::Constant(4.0) + uniform3(random, 1.9);
    const auto axis = static_cast<Eigen::Index>(random.below(3));
    p[axis] = std::floor(p[axis]);
    const Vector3 step = 1e-9 * Vector3::Unit(axis);
    EXPECT_LT((spline.sample(p + step)[0].gradient - spline.sample(p - step)[0].gradient).norm(), 1e-7);
  }
}

TEST(SplineField, TwoFieldsOverOneLatticeAreAsEachAlone) {
  const Lattice lattice = cube_of(13);
  const auto other = values_of(lattice, [](const Vector3& p) { return p.x() * p.y(); });
  const auto both = SplineFields<2>::through(lattice, {values_of(lattice, wave), other});
  const auto first = spline_of(lattice), second = SplineFields<1>::through(lattice, {other});
  Random random(5, "tissue/two");
  for (int i = 0; i < 100; ++i) {
    const Vector3 p = uniform3(random, 0.04);
    const auto s = both.sample(p);
    EXPECT_DOUBLE_EQ(s[0].value, first.sample(p)[0].value);
    EXPECT_DOUBLE_EQ(s[1].value, second.sample(p)[0].value);
    EXPECT_LT((s[1].gradient - second.sample(p)[0].gradient).norm(), 1e-12);
  }
}

TEST(SplineField, CoversWhatItCanBeSampledAtAndNothingElse) {
  const Lattice lattice{{0, 0, 0}, 0.001, {6, 7, 8}};
  EXPECT_TRUE(lattice.covers({0.001, 0.001, 0.001}));
  EXPECT_TRUE(lattice.covers({0.00399, 0.00499, 0.00599}));
  for (const Vector3& p :
       {Vector3(0.00099, 0.002, 0.002), Vector3(0.002, 0.00501, 0.002), Vector3(0.002, 0.002, 1e300),
        Vector3(0.002, std::nan(""), 0.002), Vector3(-std::numeric_limits<double>::infinity(), 0.002, 0.002)})
    EXPECT_FALSE(lattice.covers(p));
}

TEST(SplineField, WhatCannotCarryASplineIsRefused) {
  const auto made = [](const Lattice& lattice, std::size_t numbers, float number) {
    return SplineFields<1>(lattice, std::vector<float>(numbers, number));
  };
  const Lattice good{{0, 0, 0}, 0.001, {4, 4, 4}};
  EXPECT_NO_THROW(made(good, 64, 1.0f));
  EXPECT_THROW(made(good, 63, 1.0f), std::invalid_argument);
  EXPECT_THROW(made(good, 64, std::nanf("")), std::invalid_argument);
  EXPECT_THROW(made({{0, 0, 0}, 0.0, {4, 4, 4}}, 64, 1.0f), std::invalid_argument);
  EXPECT_THROW(made({{0, 0, 0}, 0.001, {3, 4, 4}}, 48, 1.0f), std::invalid_argument);
  std::vector<double> too_few(63);
  EXPECT_THROW(spline_coefficients(good, too_few), std::invalid_argument);
}

TEST(SplineField, SamplingAllocatesNothing) {
  const auto spline = spline_of(cube_of(9));
  const std::size_t before = allocations();
  double sum = 0.0;
  for (int i = 0; i < 100; ++i) sum += spline.sample({1e-4 * i, 0.0, 0.0})[0].value;
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_NE(sum, 0.0);
}

}  // namespace
}  // namespace palpate::physics::tissue
