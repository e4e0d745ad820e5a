#include "drivers/network/send_queue.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include "palpate/core/random.h"

namespace palpate::drivers::network {
namespace {

// Messages "<0>", "<1>", ... leave in pieces of any size while more come than can leave.
TEST(SendQueue, WhatLeavesIsWholeMessagesInOrderHoweverItLeaves) {
  Random random(1, "igtl/send-queue");
  SendQueue queue;
  std::string left;
  int lost = 0, ended = 0, begun = 0;
  for (; begun < 2000; ++begun) {
    lost += !queue.push(std::make_shared<const std::string>(fmt::format("<{}>", begun)), 5);
    for (auto pieces = random.below(3); pieces > 0 && !queue.empty(); --pieces) {
      const auto piece = queue.next().substr(0, 1 + random.below(4));
      left += piece;
      ended += queue.sent(piece.size());
    }
  }
  while (!queue.empty()) {
    left += queue.next();
    ended += queue.sent(queue.next().size());
  }
  EXPECT_GT(lost, 100);
  EXPECT_EQ(ended + lost, begun);
  int last = -1, count = 0;
  for (std::size_t at = 0; at < left.size(); ++count) {
    ASSERT_EQ(left[at], '<');
    const auto end = left.find_first_of("<>", at + 1);
    ASSERT_NE(end, std::string::npos);
    ASSERT_EQ(left[end], '>') << "a message was cut off";
    const int number = std::stoi(left.substr(at + 1, end - at - 1));
    ASSERT_GT(number, last);
    last = number;
    at = end + 1;
  }
  EXPECT_EQ(count, ended);
  EXPECT_EQ(last, begun - 1) << "the newest is never lost";
}

}  // namespace
}  // namespace palpate::drivers::network
