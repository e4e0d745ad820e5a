#include "palpate/desktop/warnings.h"

#include <gtest/gtest.h>

#include <functional>

namespace palpate::desktop {
namespace {

using device::ForceCondition;
using device::ForceFault;
using device::ForceState;

constexpr double kLook = 0.1;  // s between looks: the slowest drawing the header speaks of

bool stands(const Warnings& warnings, Trouble trouble) {
  for (const auto& one : warnings.shown())
    if (one.trouble == trouble) return true;
  return false;
}

std::string words(const Warnings& warnings, Trouble trouble) {
  for (const auto& one : warnings.shown())
    if (one.trouble == trouble) return one.words;
  return "";
}

struct Case {
  Trouble trouble;
  // How the system looks `since` seconds after the cause began.
  std::function<void(Standing&, double since)> cause;
  std::string says;
};

std::vector<Case> cases() {
  return {
      {Trouble::physics, [](Standing& c, double since) { c.since_physics_s = since; }, "physics server"},
      {Trouble::device, [](Standing& c, double) { c.devices = {"camera: unplugged"}; }, "camera: unplugged"},
      {Trouble::late, [](Standing& c, double) { c.late_share = 0.5; }, "50 %"},
      {Trouble::old, [](Standing& c, double) { c.state_old = true; }, "no longer has"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::safe, ForceFault::overspeed};
       },
       "off: they come back"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::safe, ForceFault::overspeed};
         c.felt = false;
       },
       "Too fast: the force rests"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::safe, ForceFault::arm_unchecked};
       },
       "off: nobody has checked"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::degraded, ForceFault::button_released};
       },
       "stylus' button"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::safe, ForceFault::arm_lost};
       },
       "off (arm lost): R"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::degraded, ForceFault::none};
       },
       "weakened (motors warm)"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::safe, ForceFault::law_failed};
         c.culprit = "cube";
       },
       "off (contact law failed, cube): R"},
      {Trouble::forces,
       [](Standing& c, double) {
         c.forces = ForceCondition{ForceState::degraded, ForceFault::stale_input};
         c.culprit = "cube";
         c.failure = "the application 'cube' threw: it broke";
       },
       "off: the application 'cube' threw: it broke"},
      {Trouble::refusal, [](Standing& c, double) { c.refusal = "observers may not serve"; }, "may not serve"},
  };
}

TEST(Warnings, SayNothingWhileAllIsWell) {
  Warnings warnings;
  for (const std::optional<ForceCondition> forces :
       {std::optional<ForceCondition>(), std::optional(ForceCondition{ForceState::running}),
        std::optional(ForceCondition{ForceState::ready})}) {
    Standing fine;
    fine.forces = forces;
    fine.late_share = 0.1;
    for (int i = 0; i < 30; ++i) warnings.look(kLook * i, fine);
    EXPECT_TRUE(warnings.shown().empty()) << words(warnings, warnings.shown().front().trouble);
  }
}

TEST(Warnings, ComeWithinHalfASecondAndGoWithTheirCause) {
  for (const auto& one : cases()) {
    for (const double phase : {0.0, 0.03, 0.07}) {  // of the looks against the cause's beginning
      Warnings warnings;
      double t = phase;
      for (; t < 1.0; t += kLook) warnings.look(t, {});
      const double begins = 1.0;
      double told = 1e9;
      for (; t < 3.0; t += kLook) {
        Standing wrong;
        one.cause(wrong, t - begins);
        warnings.look(t, wrong);
        if (told > 1e8 && stands(warnings, one.trouble)) told = t - begins;
      }
      EXPECT_LE(told, 0.5) << one.says;
      EXPECT_NE(words(warnings, one.trouble).find(one.says), std::string::npos)
          << words(warnings, one.trouble);
      EXPECT_EQ(warnings.shown().size(), 1u) << one.says;  // and nothing that only follows from it
      const double ends = t;
      for (; t < ends + 0.5; t += kLook) warnings.look(t, {});
      EXPECT_TRUE(warnings.shown().empty()) << one.says;
    }
  }
}

TEST(Warnings, DoNotFlickerForASingleBadSample) {
  for (const auto& one : cases()) {
    if (one.trouble == Trouble::device || one.trouble == Trouble::physics ||
        one.trouble == Trouble::refusal || one.says.starts_with("off") || one.says.starts_with("Too fast"))
      continue;  // these are judged elsewhere, say themselves how long, or come once
    Warnings warnings;
    for (int i = 0; i < 60; ++i) {
      Standing c;
      if (i % 6 == 0) one.cause(c, 0.0);  // one picture of six at 30 Hz
      warnings.look(i / 30.0, c);
      EXPECT_TRUE(warnings.shown().empty()) << one.says;
    }
  }
}

TEST(Warnings, StandThroughAShortRecovery) {
  Warnings warnings;
  Standing old;
  old.state_old = true;
  for (double t = 0.0; t < 1.0; t += 0.033) warnings.look(t, old);
  ASSERT_TRUE(stands(warnings, Trouble::old));
  warnings.look(1.033, {});
  warnings.look(1.066, old);
  EXPECT_TRUE(stands(warnings, Trouble::old));
  warnings.look(1.100, {});
  EXPECT_TRUE(stands(warnings, Trouble::old));
}

TEST(Warnings, NameTheMostImportantFirst) {
  Warnings warnings;
  Standing c;
  c.late_share = 1.0;
  c.devices = {"camera: unplugged", "tracker: blind"};
  c.forces = ForceCondition{ForceState::safe, ForceFault::arm_lost};
  for (double t = 0.0; t < 1.0; t += kLook) warnings.look(t, c);
  const auto shown = warnings.shown();
  ASSERT_EQ(shown.size(), 4u);
  EXPECT_EQ(shown[0].words, "camera: unplugged");  // in the order in which they began
  EXPECT_EQ(shown[1].words, "tracker: blind");
  EXPECT_EQ(shown[2].trouble, Trouble::late);
  EXPECT_EQ(shown[3].trouble, Trouble::forces);
}

// The graphics server has waited already, and would not have them stand a moment longer.
TEST(Warnings, ShowWhatTheGraphicsServerSaysOfDevicesAtOnceAndWordForWord) {
  Warnings warnings;
  Standing blind;
  blind.devices = {"tracker: does not see the head's marker; turn it towards the tracker"};
  warnings.look(1.0, blind);
  ASSERT_EQ(warnings.shown().size(), 1u);
  EXPECT_EQ(warnings.shown()[0].words, blind.devices[0]);
  warnings.look(1.01, {});
  EXPECT_TRUE(warnings.shown().empty());
}

}  // namespace
}  // namespace palpate::desktop
