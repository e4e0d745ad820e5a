#include "palpate/physics/flight_file.h"

#include <gtest/gtest.h>

namespace palpate::physics {
namespace {

const std::string kHead = "t_s,x_m,y_m,z_m\n";

std::string complaint(const std::string& content) {
  const auto balls = parse_flight(content, "flight.csv");
  if (balls) return "none";
  EXPECT_EQ(balls.error().kind, Error::Kind::wrong_use);
  return balls.error().message;
}

TEST(FlightFile, RowsWhoseTimeDoesNotIncreaseAreLeftOut) {
  const auto balls = parse_flight("vx_mps," + kHead + "9,0,1,2,3\n9,0,7,7,7\n9,0.1,4,5,6\n", "flight.csv");
  ASSERT_TRUE(balls.has_value()) << balls.error().message;
  ASSERT_EQ(balls->size(), 2u);
  EXPECT_EQ(balls->back().time, 0.1);
  EXPECT_EQ(balls->back().position, Vector3(4, 5, 6));
}

TEST(FlightFile, WhatIsNoFlightIsRefused) {
  EXPECT_NE(complaint(kHead).find("no balls"), std::string::npos);
  EXPECT_NE(complaint("t_s,x_m,y_m\n0,1,2\n").find("'z_m' is missing"), std::string::npos);
  EXPECT_NE(complaint(kHead + "0,1,2,1e300\n").find("z_m is 1e+300"), std::string::npos);
}

// The simulator flies in steps of milliseconds: an hour of it would seem to hang.
TEST(FlightFile, NoBallFliesForAnHour) {
  EXPECT_EQ(complaint(kHead + "0,0,0,1\n50,0,0,1\n"), "none");
  EXPECT_NE(complaint(kHead + "0,0,0,1\n3600,0,0,1\n").find("flight.csv: lasts 3.6e+03 s"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate::physics
