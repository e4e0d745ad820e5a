#include "palpate/network/exchange_ledger.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

Instant<GraphicsClock> at(double s) { return Instant<GraphicsClock>::from_seconds(s); }

TEST(ExchangeLedger, NumbersMustGrow) {
  ExchangeLedger ledger;
  EXPECT_FALSE(ledger.may_send(0));
  EXPECT_TRUE(ledger.may_send(5));
  ledger.sent(5, at(0));
  EXPECT_FALSE(ledger.may_send(5));
  EXPECT_FALSE(ledger.may_send(4));
}

TEST(ExchangeLedger, RepliesAreTakenOnceAndInTheOrderOfTheirRequests) {
  ExchangeLedger ledger;
  for (std::uint64_t n = 1; n <= 3; ++n) ledger.sent(n, at(static_cast<double>(n)));
  EXPECT_TRUE(ledger.reply(2, AnswerKind::exact).newest);
  const auto overtaken = ledger.reply(1, AnswerKind::too_old);
  EXPECT_TRUE(overtaken.first);
  EXPECT_FALSE(overtaken.newest);
  EXPECT_EQ(overtaken.sent, at(1.0));
  EXPECT_FALSE(ledger.reply(2, AnswerKind::exact).first);
  EXPECT_FALSE(ledger.reply(9, AnswerKind::exact).first);
  const ExchangeCounters& c = ledger.counters();
  EXPECT_EQ(c.replies, 2u);
  EXPECT_EQ(c.out_of_order, 1u);
  EXPECT_EQ(c.duplicated, 1u);
  EXPECT_EQ(c.unknown, 1u);
  EXPECT_EQ(c.answers, (std::array<std::uint64_t, 5>{1, 0, 0, 1, 0}));
}

TEST(ExchangeLedger, AReplyAfterItsFrameIsLateAndAfterTheTimeLimitNoLongerLost) {
  ExchangeLedger ledger;
  ledger.sent(1, at(0.0));
  ledger.drawn(1);
  ledger.expire(at(0.9));
  EXPECT_EQ(ledger.counters().lost, 0u);
  ledger.expire(at(1.1));
  ledger.expire(at(1.2));
  EXPECT_EQ(ledger.counters().lost, 1u);
  ledger.reply(1, AnswerKind::exact);
  EXPECT_EQ(ledger.counters().lost, 0u);
  EXPECT_EQ(ledger.counters().late, 1u);
}

TEST(ExchangeLedger, WhatIsForgottenUnansweredIsLost) {
  ExchangeLedger ledger;
  for (std::uint64_t n = 1; n <= 1000; ++n) ledger.sent(n, at(0.0));
  EXPECT_EQ(ledger.counters().lost, 1000u - 256u);
  ledger.reply(1, AnswerKind::exact);
  EXPECT_EQ(ledger.counters().unknown, 1u);
}

}  // namespace
}  // namespace palpate
