// A calibrated rig verified in the simulated laboratory on another day, as it was and after a knock.
#include "palpate/calibration/session/verification_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <thread>
#include <vector>

#include "palpate/evaluation/verification_lab_for_tests.h"
#include "tests/chi_square.h"

namespace palpate::evaluation {
namespace {

using calibration::session::CalibrationPlan;
using calibration::session::VerificationPlan;

TEST(VerificationSession, AQuickLookTellsAKnockFromAnotherDaysNoise) {
  const rig::Rig rig = calibrated_rig(3, CalibrationPlan());
  ASSERT_FALSE(testing::Test::HasFailure());
  for (const Knock knock : {Knock::none, Knock::camera_turn, Knock::base_shift, Knock::stylus, Knock::lens}) {
    const auto verified = verified_rig(knocked_world(knock, 3), 3, 1, rig, VerificationPlan::quick());
    EXPECT_EQ(names_of(verified.found), name_told_of(knock)) << static_cast<int>(knock);
    EXPECT_LT(verified.seconds, 40.0) << "of the laboratory's time";
  }
}

TEST(VerificationSession, ARigThatLacksSomethingIsRefusedBeforeAnybodyIsAsked) {
  const sim::config::WorldFile file = sim::config::reference_world();
  sim::Simulator world(file, 1);
  calibration::session::VerificationHooks hooks;
  hooks.find_landmarks = calibration::session::landmark_finder();
  const auto none = calibration::session::observe_rig(laboratory_of(world), blank_rig(file), {}, hooks);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("lacks its arm"), std::string::npos);
  EXPECT_EQ(world.now().seconds(), 0.0);
}

// Its driver gives a new reading three times a second only, whatever it says of its stamps.
class StutteringArm : public device::ArmDevice {
 public:
  explicit StutteringArm(device::ArmDevice& arm) : arm_(arm) {}
  device::ArmSample read() override {
    device::ArmSample sample = arm_.read();
    if (reads_++ % 333 == 0) held_ = sample.joints;
    sample.joints = held_;
    return sample;
  }
  void command(const Vector3& force) override { arm_.command(force); }
  void let_go() noexcept override { arm_.let_go(); }

 private:
  device::ArmDevice& arm_;
  device::JointVector held_;
  int reads_ = 0;
};

TEST(VerificationSession, ADelayAtWhichArmAndMarkerDoNotMoveAlikeIsNone) {
  const sim::config::WorldFile file = sim::config::reference_world();
  rig::Rig rig = blank_rig(file);
  rig.arm.emplace();
  rig.pointer_pivot.emplace();
  rig.camera.emplace();
  rig.hand_eye.emplace();
  rig.landmarks.resize(3);
  VerificationPlan moved_only;
  moved_only.poses = moved_only.corners_of_each = moved_only.landmarks = 0;
  moved_only.look_s = moved_only.board_s = 0.0;
  calibration::session::VerificationHooks hooks;
  hooks.find_landmarks = calibration::session::landmark_finder();
  for (const bool stutters : {false, true}) {
    sim::Simulator world(file, 1);
    const auto laboratory = laboratory_of(world);
    StutteringArm arm(laboratory.arm);
    const calibration::session::AcquisitionContext context{laboratory.clock,
                                                           stutters ? arm : laboratory.arm,
                                                           laboratory.tracker,
                                                           laboratory.camera,
                                                           laboratory.person,
                                                           nullptr,
                                                           true};
    const auto seen = calibration::session::observe_rig(context, rig, moved_only, hooks);
    ASSERT_TRUE(seen) << seen.error().message;
    EXPECT_EQ(seen->observed.tracker_delay_s.has_value(), !stutters) << seen->delay_correlation;
    EXPECT_GT(seen->delay_correlation, 0.9) << "a delay was found";
    EXPECT_EQ(seen->no_delay.empty(), !stutters);
    if (stutters)
      EXPECT_LT(seen->delay_correlation, 0.998);
    else
      EXPECT_GT(seen->delay_correlation, 0.999);
  }
}

struct Tally {
  int told = 0, named = 0, of = 0;
};

struct Coverage {
  const char* name;
  double TrueErrors::*truth;
  bool has_sign;
  int hits = 0, of = 0;
};

void count(std::array<Coverage, 6>& coverage, const Verified& verified, std::uint64_t seed, int knock) {
  for (auto& one : coverage)
    for (const auto& figure : verified.found.figures) {
      if (figure.name != one.name) continue;
      const double truth = verified.truth.*one.truth;
      const bool hit = figure.low <= truth && truth <= figure.high;
      ++one.of;
      one.hits += hit;
      std::printf("seed %llu knock %d %-14s %.4f (%.4f to %.4f %s) truth %.4f%s\n",
                  static_cast<unsigned long long>(seed), knock, one.name, figure.scale * figure.error,
                  figure.scale * figure.low, figure.scale * figure.high, figure.unit.c_str(),
                  figure.scale * truth, hit ? "" : "  MISSED");
    }
}

// One rig, verified as it was and after each knock.
std::array<Verified, kKnocks> verdicts_on(std::uint64_t seed, const VerificationPlan& plan) {
  const rig::Rig rig = calibrated_rig(seed, {});
  std::array<Verified, kKnocks> all;
  for (int k = 0; k < kKnocks; ++k)
    all[static_cast<std::size_t>(k)] =
        verified_rig(knocked_world(static_cast<Knock>(k), seed), seed, 1, rig, plan);
  return all;
}

// Of rigs 1 to `rigs`, each core has one in work: rigs share nothing, and a rig takes a minute and more.
std::vector<std::array<Verified, kKnocks>> verdicts(std::size_t rigs, const VerificationPlan& plan) {
  std::vector<std::array<Verified, kKnocks>> all(rigs);
  std::atomic<std::size_t> next{0};
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
    threads.emplace_back([&] {
      for (std::size_t r = next++; r < rigs; r = next++) all[r] = verdicts_on(r + 1, plan);
    });
  for (auto& thread : threads) thread.join();
  return all;
}

// Twenty rigs, each verified as it was and after each knock: what `palpate verify` is held against.
void expect_verdicts(const VerificationPlan& plan, bool with_figures) {
  std::array<Tally, kKnocks> tallies{};
  std::array<Coverage, 6> coverage{{{"arm", &TrueErrors::arm, false},
                                    {"places", &TrueErrors::places, false},
                                    {"picture", &TrueErrors::picture, false},
                                    {"tip", &TrueErrors::tip, false},
                                    {"camera delay", &TrueErrors::camera_delay, true},
                                    {"tracker delay", &TrueErrors::tracker_delay, true}}};
  std::uint64_t seed = 0;
  for (const auto& of_rig : verdicts(20, plan)) {
    ++seed;
    for (int k = 0; k < kKnocks; ++k) {
      const auto knock = static_cast<Knock>(k);
      const Verified& verified = of_rig[static_cast<std::size_t>(k)];
      const std::string names = names_of(verified.found);
      auto& tally = tallies[static_cast<std::size_t>(k)];
      ++tally.of;
      tally.told += !verified.found.holds();
      tally.named += names == name_told_of(knock);
      std::printf("seed %llu knock %d: '%s' wanted '%s' misfit %.3f %.0f s\n",
                  static_cast<unsigned long long>(seed), k, names.c_str(), name_told_of(knock),
                  verified.found.misfit, verified.seconds);
      if (with_figures && knock == Knock::none) count(coverage, verified, seed, k);
    }
  }
  EXPECT_LE(tallies[0].told, 1) << "false alarms of 20";
  for (int k = 1; k < kKnocks; ++k)
    EXPECT_GE(tallies[static_cast<std::size_t>(k)].named, 19)
        << name_told_of(static_cast<Knock>(k)) << ", " << k;
  if (!with_figures) return;
  // 95 % intervals: of 20 fewer than 17 once in sixty times.
  for (const auto& one : coverage) EXPECT_GE(one.hits, 17) << one.name << " of " << one.of;
}

TEST(VerificationSessionStatistics, TwentyRigsInFull) { expect_verdicts({}, true); }

TEST(VerificationSessionStatistics, TwentyRigsQuickly) { expect_verdicts(VerificationPlan::quick(), false); }

}  // namespace
}  // namespace palpate::evaluation
