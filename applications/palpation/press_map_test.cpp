#include "applications/palpation/press_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/random.h"
#include "palpate/experiment/observer.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kSpacing = 0.010;

// The logarithm of the force over a nodule of 15 mm whose top lies 5 mm deep, 10 times stiffer: contrasts at 0, 4, 8,
// 12, 16 and 20 mm beside it, of neo-Hookean solutions.
double nodule_log(double beside) {
  constexpr double kContrast[] = {1.41, 1.36, 1.21, 1.09, 1.03, 1.01, 1.0};
  const double at = std::min(beside / 0.004, 5.999);
  const auto i = static_cast<std::size_t>(at);
  return std::log(kContrast[i] + (at - static_cast<double>(i)) * (kContrast[i + 1] - kContrast[i]));
}

// Whether the best guess lies within 10 mm, over many searches.
double share_found(double weber, bool senses, bool uneven, int searches = 400) {
  Random random(11, "press map test");
  int found = 0;
  for (int search = 0; search < searches; ++search) {
    const auto places = grid_of({0.0, 0.0}, {0.045, 0.035}, kSpacing);
    const PlanPlace nodule(random.uniform(-0.030, 0.030), random.uniform(-0.022, 0.022));
    PressMap map(places, kSpacing, experiment::noise_of_weber_fraction(weber),
                 uneven ? PressMap::Trend::quadratic : PressMap::Trend::level);
    experiment::Observer observer({.weber_fraction = weber, .lapse_rate = 0.0}, random.bits());
    const auto press = [&](std::size_t i) {
      const PlanPlace& p = places[i];
      const double slow = uneven ? 0.3 * p.x() / 0.045 - 0.25 * p.y() * p.y() / (0.035 * 0.035) : 0.0;
      map.felt(i, observer.perceived(senses ? std::exp(slow + nodule_log((p - nodule).norm())) : 1.0));
    };
    for (std::size_t i = 0; i < places.size(); ++i) press(i);
    for (int k = 0; k < 2; ++k)
      for (const std::size_t i : map.best(5)) press(i);
    const auto guess = map.believed(1, 1, 0.018);
    found += guess.size() == 1 && (guess[0] - nodule).norm() <= 0.010;
  }
  return static_cast<double>(found) / searches;
}

TEST(PressMap, AGridGoesToAndFroOnItsEllipse) {
  const auto places = grid_of({0.1, 0.0}, {0.02, 0.01}, kSpacing);
  ASSERT_EQ(places.size(), 7u) << "one above, five in the middle, one below";
  EXPECT_NEAR((places[1] - PlanPlace(0.12, 0.0)).norm(), 0.0, 1e-12) << "the second row comes back";
  for (std::size_t i = 1; i < places.size(); ++i) EXPECT_LE((places[i] - places[i - 1]).norm(), 0.0224);
}

TEST(PressMap, WithoutNoiseItFindsTheNoduleOnAnOrganThatIsNotEven) {
  EXPECT_GT(share_found(1e-6, true, false), 0.97);
  EXPECT_GT(share_found(1e-6, true, true), 0.90);
}

TEST(PressMap, TheDullerTheSenseTheLessIsFound) {
  const double fine = share_found(0.08, true, false), dull = share_found(0.28, true, false);
  EXPECT_GT(fine, 0.85);
  EXPECT_LT(dull, fine - 0.15);
  EXPECT_GT(dull, 0.25);
}

// A disc of 10 mm on an area of 90 x 70 mm: by lot about one in fifteen, the rim counted.
TEST(PressMap, WithoutSenseItFindsNoMoreThanByLot) { EXPECT_LT(share_found(0.14, false, true), 0.14); }

TEST(PressMap, MarksAsManyAsItSurelyFeels) {
  const auto places = grid_of({0.0, 0.0}, {0.045, 0.035}, kSpacing);
  PressMap map(places, kSpacing, 0.05, PressMap::Trend::level);
  for (std::size_t i = 0; i < places.size(); ++i)
    map.felt(i, nodule_log((places[i] - PlanPlace(-0.02, 0.01)).norm()) +
                    nodule_log((places[i] - PlanPlace(0.02, -0.01)).norm()));
  EXPECT_EQ(map.believed(0, 3, 0.018).size(), 2u);
  EXPECT_EQ(map.believed(0, 1, 0.018).size(), 1u);
  EXPECT_EQ(map.believed(3, 3, 0.018).size(), 3u) << "by lot, where it is told that there are three";
}

}  // namespace
}  // namespace palpate::applications::palpation
