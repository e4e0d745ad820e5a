#include "palpate/transport/request_tracker.h"

#include <gtest/gtest.h>

namespace palpate::transport {
namespace {

Instant<GraphicsClock> at(double s) { return Instant<GraphicsClock>::from_seconds(s); }

TEST(RequestTracker, NumbersMustGrow) {
  RequestTracker request_tracker;
  EXPECT_FALSE(request_tracker.may_send(0));
  EXPECT_TRUE(request_tracker.may_send(5));
  request_tracker.sent(5, at(0));
  EXPECT_FALSE(request_tracker.may_send(5));
  EXPECT_FALSE(request_tracker.may_send(4));
}

TEST(RequestTracker, RepliesAreTakenOnceAndInTheOrderOfTheirRequests) {
  RequestTracker request_tracker;
  for (std::uint64_t n = 1; n <= 3; ++n) request_tracker.sent(n, at(static_cast<double>(n)));
  EXPECT_TRUE(request_tracker.reply(2, AnswerKind::exact).newest);
  const auto overtaken = request_tracker.reply(1, AnswerKind::too_old);
  EXPECT_TRUE(overtaken.first);
  EXPECT_FALSE(overtaken.newest);
  EXPECT_EQ(overtaken.sent, at(1.0));
  EXPECT_FALSE(request_tracker.reply(2, AnswerKind::exact).first);
  EXPECT_FALSE(request_tracker.reply(9, AnswerKind::exact).first);
  const ExchangeCounters& c = request_tracker.counters();
  EXPECT_EQ(c.replies, 2u);
  EXPECT_EQ(c.out_of_order, 1u);
  EXPECT_EQ(c.duplicated, 1u);
  EXPECT_EQ(c.unknown, 1u);
  EXPECT_EQ(c.answers, (std::array<std::uint64_t, 5>{1, 0, 0, 1, 0}));
}

TEST(RequestTracker, AReplyAfterItsFrameIsLateAndAfterTheTimeLimitNoLongerLost) {
  RequestTracker request_tracker;
  request_tracker.sent(1, at(0.0));
  request_tracker.drawn(1);
  request_tracker.expire(at(0.9));
  EXPECT_EQ(request_tracker.counters().lost, 0u);
  request_tracker.expire(at(1.1));
  request_tracker.expire(at(1.2));
  EXPECT_EQ(request_tracker.counters().lost, 1u);
  request_tracker.reply(1, AnswerKind::exact);
  EXPECT_EQ(request_tracker.counters().lost, 0u);
  EXPECT_EQ(request_tracker.counters().late, 1u);
}

TEST(RequestTracker, WhatIsForgottenUnansweredIsLost) {
  RequestTracker request_tracker;
  for (std::uint64_t n = 1; n <= 1000; ++n) request_tracker.sent(n, at(0.0));
  EXPECT_EQ(request_tracker.counters().lost, 1000u - 256u);
  request_tracker.reply(1, AnswerKind::exact);
  EXPECT_EQ(request_tracker.counters().unknown, 1u);
}

}  // namespace
}  // namespace palpate::transport
