#include "palpate/transport/internal/shape_pool.h"

#include <gtest/gtest.h>

#include <optional>

namespace palpate::transport {
namespace {

TEST(ShapePool, LendsFourToOnePeerAndSixtyFourInAll) {
  ShapePool pool(10);
  std::vector<std::shared_ptr<scene::Shape>> out;
  for (int peer = 0; peer < 16; ++peer) {
    for (int i = 0; i < 4; ++i) {
      out.push_back(pool.take(std::to_string(peer)));
      ASSERT_TRUE(out.back());
      EXPECT_EQ(out.back()->vertices(), 10u);
    }
    EXPECT_FALSE(pool.take(std::to_string(peer)));
  }
  EXPECT_FALSE(pool.take("another"));
  const scene::Shape* returned = out[5].get();
  out[5].reset();
  EXPECT_FALSE(pool.take("0"));
  const auto again = pool.take("another");
  EXPECT_EQ(again.get(), returned);  // not made anew
}

TEST(ShapePool, MayGoBeforeWhatItLent) {
  std::optional<ShapePool> pool(std::in_place, 3);
  const auto shape = pool->take("peer");
  pool.reset();
  shape->values.at(17) = 1.0F;
  EXPECT_EQ(shape->vertices(), 3u);
}

}  // namespace
}  // namespace palpate::transport
