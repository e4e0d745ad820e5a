#include "palpate/figures/plot.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::figures {
namespace {

TEST(Histogram, CountsEachValueOnce) {
  const Series counts = histogram("h", {-5.0, 0.0, 0.49, 0.5, 0.99, 1.0, 9.0, NAN}, 0.0, 1.0, 2);
  EXPECT_EQ(counts.x, (std::vector<double>{0.25, 0.75}));
  EXPECT_EQ(counts.y, (std::vector<double>{3.0, 4.0}));  // outside values in the outermost bins
}

TEST(Cumulative, EndsAtOneWithTheLargestValue) {
  const Series share = cumulative("c", {3.0, 1.0, 2.0, 4.0});
  EXPECT_EQ(share.x, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(share.y, (std::vector<double>{0.25, 0.5, 0.75, 1.0}));
  const Series thinned = cumulative("c", std::vector<double>(5000, 2.0));
  EXPECT_EQ(thinned.x.size(), 200u);
  EXPECT_EQ(thinned.y.back(), 1.0);
}

}  // namespace
}  // namespace palpate::figures
