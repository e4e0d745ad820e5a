#include "drivers/openhaptics/opening.h"

#include <gtest/gtest.h>

#include "drivers/openhaptics/stub_for_tests.h"

namespace palpate::drivers::openhaptics {
namespace {

using OpenHapticsOpening = StubTest;

TEST_F(OpenHapticsOpening, WhatCannotBeOpenedIsRefusedWithReasonAndRemedy) {
  const auto refusal = [](const ArmSettings& settings) {
    const auto arm = OpenHapticsArm::open(settings);
    return arm ? std::string("opened") : arm.error().message;
  };
  auto settings = patient();
  settings.name = "Middle";
  EXPECT_TRUE(says(refusal(settings), {"device 'Middle'", "HD_DEVICE_FAULT", "power"}));
  settings.name = "";
  const auto first = opened(settings);
  EXPECT_TRUE(says(refusal(settings), {"HD_DEVICE_ALREADY_INITIATED", "stop the other program"}));
  settings.name = "Left";
  for (const auto& [code, word] : std::initializer_list<std::pair<unsigned, const char*>>{
           {0x0600, "licence"}, {0x0302, "/dev"}, {0x0303, "setup program"}, {0x0304, "real-time rights"}}) {
    with([error = code](HdStubDevice& d) { d.init_error = error; }, 1);
    EXPECT_TRUE(says(refusal(settings), {"device 'Left'", word}));
  }
  with([](HdStubDevice& d) { d.init_error = 0, d.input_dof = 3; }, 1);
  EXPECT_TRUE(says(refusal(settings), {"measures 3 directions", "6 and 3 are expected", "gimbal"}));
  EXPECT_FALSE(with([](HdStubDevice& d) { return d.open; }, 1));
  with([](HdStubDevice& d) { d.input_dof = 6, d.nominal_force = 0.0; }, 1);
  EXPECT_TRUE(says(refusal(settings), {"states 0 N", "setup program"}));
  settings.library = "/nowhere/libHD.so";
  EXPECT_TRUE(says(refusal(settings), {"/nowhere/libHD.so is not there", "PALPATE_LIBHD"}));
}

TEST_F(OpenHapticsOpening, ProbingAsksAndGivesBack) {
  const auto facts = probe_arm(patient());
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->model, "Simulated PHANToM");
  EXPECT_FALSE(with([](HdStubDevice& d) { return d.open; }));
  EXPECT_EQ(with([](HdStubDevice& d) { return d.cycles; }), 0u);
  EXPECT_FALSE(scheduler_runs());
}

}  // namespace
}  // namespace palpate::drivers::openhaptics
