// Searches of a grid against shares that were computed elsewhere, and against chance by counting.
#include "applications/palpation/block_search.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::applications::palpation {
namespace {

// Over a nodule of 15 mm whose top lies 5 mm deep, 10 times stiffer: contrasts at 0, 4, ... 24 mm beside it, of neo-Hookean
// finite-element solutions that share nothing with ours, with straight lines between them in steps of 1 mm.
ContrastProfile known_profile() {
  constexpr double kForce[] = {1.41, 1.36, 1.21, 1.09, 1.03, 1.01, 1.0};
  std::vector<double> contrasts;
  for (std::size_t mm = 0; mm < 24; ++mm)
    contrasts.push_back(
        std::log(std::lerp(kForce[mm / 4], kForce[mm / 4 + 1], 0.25 * static_cast<double>(mm % 4))));
  return ContrastProfile(std::move(contrasts), 0.001);
}

double percent(double weber) {
  return 100.0 * grid_share(known_profile(), {.weber_fraction = weber, .seed = 5});
}

TEST(BlockSearch, GridFindsAsMuchAsWasComputedElsewhereForTheseWeberFractions) {
  // 4000 searches: standard deviation 0.8 of a hundred.
  EXPECT_NEAR(percent(0.28), 49.0, 3.0);
  EXPECT_NEAR(percent(0.22), 63.0, 3.0);
  EXPECT_NEAR(percent(0.18), 75.0, 3.0);
  EXPECT_NEAR(percent(0.14), 89.0, 3.0);
  EXPECT_NEAR(percent(0.08), 100.0, 3.0);
}

// By lot every place of the grid is the answer equally often: the share of places within 10 mm of a nodule, counted over a
// fine net of nodules.
TEST(BlockSearch, WithTheSenseOffItFindsByLot) {
  double near = 0.0, all = 0.0;
  for (double x = -0.03975; x < 0.04; x += 0.0005)
    for (double z = -0.02775; z < 0.028; z += 0.0005)
      for (int i = 0; i < 10; ++i)
        for (int k = 0; k < 7; ++k, ++all)
          near += std::hypot(x - (-0.045 + 0.01 * i), z - (-0.03 + 0.01 * k)) <= 0.010;
  const double expected = near / all;
  constexpr int kSearches = 4000;
  const double share = grid_share(known_profile(), {.senses = false, .searches = kSearches, .seed = 8});
  EXPECT_NEAR(share, expected, 4.0 * std::sqrt(expected * (1.0 - expected) / kSearches));
  EXPECT_EQ(share, grid_share(known_profile(), {.senses = false, .searches = kSearches, .seed = 8}));
}

TEST(BlockSearch, AFreerSearchFindsAtLeastAsMuch) {
  const SearchTask task{.weber_fraction = 0.14, .searches = 300, .seed = 5};
  // Standard deviation of either 0.018.
  EXPECT_GT(freer_share(known_profile(), task), grid_share(known_profile(), task) - 0.08);
}

TEST(BlockSearch, AProfileIsReadBetweenItsPlacesAndFadesOut) {
  const ContrastProfile profile({0.4, 0.2, 0.1});
  EXPECT_NEAR(profile.at(0.002), (9.0 * (0.4 + 0.2) - 0.2 - 0.1) / 16.0, 1e-12) << "a cubic, even about 0";
  EXPECT_NEAR(profile.at(0.012), 0.05, 1e-12);
  EXPECT_EQ(profile.at(0.017), 0.0);
}

}  // namespace
}  // namespace palpate::applications::palpation
