#include "palpate/core/trace_log.h"

#include <gtest/gtest.h>

#include "palpate/core/json.h"

namespace palpate::inline core {
namespace {

TEST(TraceLog, IsTheTraceEventFormat) {
  TraceLog log("a \"process\"");
  log.add("frame", 5'000'000'123, 5'033'000'123, 7);
  log.add("draw", 5'010'000'000, 5'012'500'000, 7);
  const Json trace = Json::parse(log.json());
  const Json& events = trace["traceEvents"];
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0]["ph"], "M");
  EXPECT_EQ(events[0]["args"]["name"], "a \"process\"");
  EXPECT_EQ(events[1]["name"], "frame");
  EXPECT_EQ(events[1]["ph"], "X");
  EXPECT_NEAR(events[1]["ts"].get<double>(), 5'000'000.123, 1e-3);
  EXPECT_NEAR(events[1]["dur"].get<double>(), 33'000.0, 1e-3);
  EXPECT_EQ(events[2]["args"]["frame"], 7);
  EXPECT_EQ(events[1]["pid"], events[2]["pid"]);
}

TEST(TraceLog, WhatDoesNotFitIsCounted) {
  TraceLog log("x", 2);
  for (int i = 0; i < 5; ++i) log.add("a", i, i + 1, 0);
  EXPECT_EQ(log.count(), 2u);
  EXPECT_EQ(log.left_out(), 3u);
  EXPECT_EQ(Json::parse(log.json())["traceEvents"].size(), 3u);
}

TEST(TraceLog, AnEmptyOneCanBeOpened) {
  EXPECT_EQ(Json::parse(TraceLog("x").json())["traceEvents"].size(), 1u);
}

}  // namespace
}  // namespace palpate::inline core
