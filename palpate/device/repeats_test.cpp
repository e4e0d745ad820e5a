#include "palpate/device/repeats.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

struct Item {
  int number;
  Eigen::Vector3d place;
  std::optional<double> time;
};

Reading reading(const Item& item) { return Reading().add(item.place).add_if(item.time); }

TEST(Repeats, EachReadingStaysOnceAndTheFirstOfEach) {
  std::vector<Item> items{{1, {0, 1, 2}, {}},  {2, {0, 1, 3}, {}},    {3, {0, 1, 2}, {}},
                          {4, {0, 1, 2}, 0.0}, {5, {-0.0, 1, 3}, {}}, {6, {0, 1, 2 + 1e-15}, {}}};
  EXPECT_EQ(drop_repeats(items, reading), 2u);
  std::vector<int> left;
  for (const auto& item : items) left.push_back(item.number);
  EXPECT_EQ(left, (std::vector<int>{1, 2, 4, 6}));
}

TEST(Repeats, TheWarningCounts) {
  EXPECT_EQ(repeats_warning(1),
            "1 row repeats an earlier one to the last digit; each measurement counts once");
  EXPECT_EQ(repeats_warning(2), "2 rows repeat earlier ones to the last digit; each measurement counts once");
}

}  // namespace
}  // namespace palpate::device
