#include "palpate/calibration/verification.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "palpate/calibration/internal/rig_figures.h"
#include "palpate/calibration/verification_rig_for_tests.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

// In a paper laboratory nothing but what is stated is wrong.
VerificationOptions paper_options() {
  VerificationOptions options;
  options.head_turn_sd = 1e-9;  // no systematic error where the head is
  options.head_shift_sd = 1e-12;
  options.delay_sd = 0.0;
  return options;
}

struct Outcome {
  rig::Rig truth, rig;
  RigObservations seen;
  Verification found;
};

// A rig is calibrated, `knock` changes the laboratory, the rig is verified.
Outcome verified(std::uint64_t seed, const std::function<void(rig::Rig&)>& knock,
                 const VerificationOptions& options = paper_options(), double camera_delay_error = 0.0) {
  Random random(seed, "verification");
  Outcome outcome;
  outcome.truth = paper_truth();
  outcome.rig = paper_rig(outcome.truth, random);
  const double delay = random.normal(PaperErrors{}.delay) + camera_delay_error;
  knock(outcome.truth);
  outcome.seen = paper_observations(outcome.truth, outcome.rig, random, delay);
  auto found = verify_rig(outcome.rig, outcome.seen, options);
  EXPECT_TRUE(found) << found.error().message;
  if (found) outcome.found = *found;
  return outcome;
}

const RigFigure* figure_of(const Verification& found, const std::string& name) {
  for (const auto& figure : found.figures)
    if (figure.name == name) return &figure;
  return nullptr;
}

std::string names_in(const Verification& found) {
  std::string names;
  for (const auto& change : found.changes) names += std::string(name_of(change.change)) + ";";
  return names + (found.explained ? "" : "unexplained;");
}

Vector3 of_size(Random& random, double size) { return size * normal3(random).normalized(); }

double rms_of(const std::vector<double>& squares) {
  double sum = 0.0;
  for (const double s : squares) sum += s;
  return std::sqrt(sum / static_cast<double>(squares.size()));
}

TEST(Verification, MisfitOfRigsThatAreWhatTheyPromisedIsChiSquare) {
  constexpr int kRigs = 40;
  double sum = 0.0, degrees = 0.0;
  int alarms = 0;
  VerificationOptions options = paper_options();
  options.false_alarm = 0.05;
  for (int i = 0; i < kRigs; ++i) {
    const auto found = verified(
                           100 + static_cast<std::uint64_t>(i), [](rig::Rig&) {}, options)
                           .found;
    if (!found.changes.empty()) {
      ++alarms;
      continue;
    }
    sum += found.misfit * found.freedoms;
    degrees += found.freedoms;
  }
  EXPECT_TRUE(tests::is_chi_square(sum, degrees));
  // Bonferroni's bound is one: alarms may be rarer.
  EXPECT_LE(alarms, tests::binomial_bracket(kRigs, 0.05).high);
}

// Told, named, and by how much, with a covariance that the misses keep to.
void expect_told(const std::string& name, std::uint64_t seed, const std::function<void(rig::Rig&)>& knock,
                 const Eigen::VectorXd& amount, double camera_delay_error = 0.0) {
  const auto outcome = verified(seed, knock, paper_options(), camera_delay_error);
  EXPECT_EQ(names_in(outcome.found), name + ";");
  if (outcome.found.changes.size() != 1) return;
  const auto& change = outcome.found.changes[0];
  ASSERT_EQ(change.amount.size(), amount.size());
  EXPECT_TRUE(tests::is_chi_square(tests::normalised_square(change.amount - amount, change.covariance),
                                   static_cast<double>(amount.size())))
      << name << ": " << change.amount.transpose() << " for " << amount.transpose();
  EXPECT_NE(change_words(change).find("palpate calibrate"), std::string::npos);
}

Eigen::VectorXd six(const Vector3& turn, const Vector3& shift) {
  Vector6 all;
  all << turn, shift;
  return all;
}

TEST(Verification, ACameraOrABaseThatWasMovedIsNamedAndByHowMuch) {
  const double half = radians_from_degrees(0.5);
  for (int i = 0; i < 4; ++i) {
    Random random(static_cast<std::uint64_t>(i), "knocks");
    const Vector3 turn = i % 2 == 0 ? of_size(random, half) : Vector3(Vector3::Zero());
    const Vector3 shift = i % 2 == 0 ? Vector3(Vector3::Zero()) : of_size(random, 4e-3);
    const auto seed = 10 + static_cast<std::uint64_t>(i);
    expect_told(
        "camera", seed,
        [&](rig::Rig& truth) {
          auto& X = truth.hand_eye->X_marker_camera;
          X = {so3_exp(turn) * X.rotation, X.translation + shift};
        },
        six(turn, shift));
    expect_told(
        "arm base", seed,
        [&](rig::Rig& truth) {
          auto& X = truth.arm->X_world_base;
          X = {so3_exp(turn) * X.rotation, X.translation + shift};
        },
        six(turn, shift));
  }
}

TEST(Verification, BentMarkersARefocusedLensAndLateDevicesAreNamed) {
  for (int i = 0; i < 3; ++i) {
    Random random(static_cast<std::uint64_t>(i), "bends");
    const Vector3 bend = of_size(random, 1e-3);
    const auto seed = 20 + static_cast<std::uint64_t>(i);
    expect_told(
        "stylus marker", seed, [&](rig::Rig& truth) { truth.arm->tip_in_marker += bend; }, bend);
    expect_told(
        "pointer", seed, [&](rig::Rig& truth) { truth.pointer_pivot->tip_in_marker += bend; }, bend);
    const double focus = i == 1 ? -0.01 : 0.01;
    expect_told(
        "lens", seed,
        [&](rig::Rig& truth) {
          auto& lens = truth.camera->model;
          lens.fx *= 1.0 + focus, lens.fy *= 1.0 + focus;
          lens.cx += 1.5, lens.cy -= 0.5;
        },
        Vector3(focus, 1.5, -0.5));
    expect_told(
        "tracker delay", seed, [](rig::Rig& truth) { truth.delays->tracker_after_arm_s += 3e-3; },
        Eigen::VectorXd::Constant(1, 3e-3));
    expect_told(
        "camera delay", seed, [](rig::Rig&) {}, Eigen::VectorXd::Constant(1, 5e-3), 5e-3);
  }
}

void carry_everything(rig::Rig& truth, const Vector3& about, const Vector3& turn, const Vector3& shift,
                      bool base_too) {
  const auto carried = [&](const Vector3& p) { return Vector3(about + so3_exp(turn) * (p - about) + shift); };
  auto& table = truth.surfaces[0].X_world_rectangle;
  table = {so3_exp(turn) * table.rotation, carried(table.translation)};
  for (auto& landmark : truth.landmarks) landmark.place.m = carried(landmark.place.m);
  auto& base = truth.arm->X_world_base;
  if (base_too) base = {so3_exp(turn) * base.rotation, carried(base.translation)};
}

TEST(Verification, TableAndTrackerAreToldApartAndALostEncoderZeroIsToldFromBoth) {
  for (int i = 0; i < 3; ++i) {
    Random random(static_cast<std::uint64_t>(i), "tables");
    const Vector3 turn = of_size(random, 4e-3), shift = of_size(random, 2e-3);
    for (const bool tracker : {false, true})
      EXPECT_EQ(names_in(verified(30 + static_cast<std::uint64_t>(i),
                                  [&](rig::Rig& truth) {
                                    carry_everything(truth, {0.0, -1.52, 1.3}, turn, shift, tracker);
                                  })
                             .found),
                tracker ? "tracker;" : "table;");
    const Vector3 zero = of_size(random, 0.05);
    const auto lost = verified(40 + static_cast<std::uint64_t>(i),
                               [&](rig::Rig& truth) { truth.arm->correction.offset += zero; });
    // The arm at rest reads otherwise by as much.
    auto seen = lost.seen;
    *seen.rest -= zero.cwiseQuotient(Vector3(lost.truth.arm->correction.gain));
    const auto found = verify_rig(lost.rig, seen, paper_options());
    ASSERT_TRUE(found);
    EXPECT_EQ(names_in(*found), "encoder zero;");
  }
}

TEST(Verification, LargeKnocksAndTwoAtOnceAreNamed) {
  expect_told(
      "camera", 50,
      [](rig::Rig& truth) {
        auto& X = truth.hand_eye->X_marker_camera;
        X = {so3_exp(Vector3(0.05, -0.03, 0.02)) * X.rotation, X.translation + Vector3(0.01, 0.005, -0.02)};
      },
      six({0.05, -0.03, 0.02}, {0.01, 0.005, -0.02}));
  const auto two = verified(51, [](rig::Rig& truth) {
    truth.arm->X_world_base.translation += Vector3(0.003, 0.0, 0.001);
    truth.camera->model.fx *= 1.02, truth.camera->model.fy *= 1.02;
  });
  EXPECT_TRUE(names_in(two.found) == "arm base;lens;" || names_in(two.found) == "lens;arm base;")
      << names_in(two.found);
}

TEST(Verification, WhatNoChangeExplainsIsSaid) {
  auto outcome = verified(60, [](rig::Rig&) {});
  ASSERT_TRUE(outcome.found.holds());
  auto seen = outcome.seen;
  for (std::size_t i = 0; i < seen.held.size(); ++i)
    seen.held[i].X_world_marker.translation.y() += i % 2 == 0 ? 0.004 : -0.004;  // a loose mount
  const auto found = verify_rig(outcome.rig, seen, paper_options());
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->holds());
  EXPECT_FALSE(found->explained);
  EXPECT_EQ(found->farthest.find("the stylus held still, pose "), 0u) << found->farthest;
  EXPECT_GT(found->farthest_sds, 10.0);
  // One place taken for another, and a dot for another.
  seen = outcome.seen;
  auto& touch = seen.touched[seen.touched.size() / 2];
  touch.X_world_pointer.translation.x() += 0.03;
  const auto wrong_place = verify_rig(outcome.rig, seen, paper_options());
  ASSERT_TRUE(wrong_place && !wrong_place->explained);
  EXPECT_EQ(wrong_place->farthest,
            fmt::format("the touch of {} {}", touch.what == "landmark" ? "landmark" : touch.what + ", corner",
                        touch.index + 1));
  seen = outcome.seen;
  ASSERT_GT(seen.frames.size(), 3u);
  seen.frames[3].dots.at(1).centre.x() += 25.0;
  const auto wrong_dot = verify_rig(outcome.rig, seen, paper_options());
  ASSERT_TRUE(wrong_dot && !wrong_dot->explained);
  EXPECT_EQ(wrong_dot->farthest, fmt::format("the landmarks in picture 4 of {}", seen.frames.size()));
}

// The rig's own errors, which the test knows, lie within the figures' intervals as often as these say.
TEST(Verification, FiguresCoverTheErrorsThatOnlyTheTruthKnows) {
  constexpr int kRigs = 40;
  int arm = 0, places = 0, camera_delay = 0, told = 0;
  for (int i = 0; i < kRigs; ++i) {
    const bool knocked = i % 2 == 1;
    const auto outcome = verified(200 + static_cast<std::uint64_t>(i), [&](rig::Rig& truth) {
      if (knocked) truth.arm->X_world_base.translation.x() += 2e-3;
    });
    told += knocked == !outcome.found.holds();
    std::vector<double> of_arm, of_places;
    for (const auto& held : outcome.seen.held) {
      const auto tip = [&held](const rig::Rig& rig) {
        return (rig.arm->X_world_base *
                device::phantom_tip(rig.arm->correction.apply(held.joints), rig.arm->model.lengths))
            .m;
      };
      of_arm.push_back((tip(outcome.rig) - tip(outcome.truth)).squaredNorm());
    }
    for (const auto& touched : outcome.seen.touched) {
      const auto place = [&touched](const rig::Rig& rig) {
        return touched.what == "table" ? rig.surfaces[0].corner(touched.index).m
                                       : rig.landmarks[static_cast<std::size_t>(touched.index)].place.m;
      };
      of_places.push_back((place(outcome.rig) - place(outcome.truth)).squaredNorm());
    }
    const auto covers = [&outcome](const char* name, double error) {
      const auto* figure = figure_of(outcome.found, name);
      return figure != nullptr && figure->low <= error && error <= figure->high;
    };
    arm += covers("arm", rms_of(of_arm));
    places += covers("places", rms_of(of_places));
    const auto* delay = figure_of(outcome.found, "tracker delay");
    ASSERT_NE(delay, nullptr);
    const double late = outcome.truth.delays->tracker_after_arm_s - outcome.rig.delays->tracker_after_arm_s;
    // The figure is the rig's value less the true one.
    camera_delay += delay->low <= -late && -late <= delay->high;
  }
  EXPECT_GE(told, kRigs - 1);
  EXPECT_TRUE(tests::is_binomial(arm, kRigs, 0.95));
  EXPECT_TRUE(tests::is_binomial(places, kRigs, 0.95));
  EXPECT_TRUE(tests::is_binomial(camera_delay, kRigs, 0.95));
}

TEST(Verification, AnRmsOfNormalErrorsLiesInItsInterval) {
  // One direction of three alone: a chi-square variable of one degree, whose quantiles the tables have.
  const auto one = rms_interval(Vector3::Zero(), Vector3(4.0, 0.0, 0.0).asDiagonal(), 1);
  EXPECT_NEAR(one.rms, 2.0, 1e-12);
  EXPECT_NEAR(one.high, 2.0 * std::sqrt(5.0239), 1e-3);
  EXPECT_NEAR(one.low, 2.0 * std::sqrt(0.000982), 1e-4);
  const auto three = rms_interval(Vector3::Zero(), Matrix3::Identity(), 1);
  EXPECT_NEAR(three.high_one_sided, std::sqrt(7.8147), 1e-3);
  const auto sure = rms_interval(Vector3(3.0, 0.0, 4.0), Matrix3::Zero(), 1);
  EXPECT_EQ(sure.low, 5.0);
  EXPECT_EQ(sure.high, 5.0);
}

TEST(Verification, WhatCannotBeVerifiedIsRefused) {
  Random random(1, "refused");
  const rig::Rig truth = paper_truth();
  rig::Rig rig = paper_rig(truth, random);
  RigObservations seen = paper_observations(truth, rig, random);
  EXPECT_FALSE(verify_rig(rig, RigObservations{}));
  RigObservations dark;  // a picture in which no dot was found is no observation
  dark.frames.emplace_back();
  EXPECT_NE(verify_rig(rig, dark).error().message.find("nothing was observed"), std::string::npos);
  dark.rest = seen.rest;
  EXPECT_TRUE(verify_rig(rig, dark));
  rig.arm->rest_known = false;  // a rig made of tables: nothing to compare with
  EXPECT_NE(verify_rig(rig, dark).error().message.find("nothing was observed"), std::string::npos);
  rig.arm->rest_known = true;
  seen.touched[0].index = 4;
  EXPECT_NE(verify_rig(rig, seen).error().message.find("table 5"), std::string::npos);
  seen.touched[0] = seen.touched[1];
  seen.frames[0].dots[0].landmark = 8;
  EXPECT_NE(verify_rig(rig, seen).error().message.find("landmark 9"), std::string::npos);
  seen.frames[0].dots[0].landmark = 0;
  seen.held[0].X_world_marker.translation.x() = std::nan("");
  EXPECT_NE(verify_rig(rig, seen).error().message.find("not a number"), std::string::npos);
  rig.hand_eye.reset();
  EXPECT_NE(verify_rig(rig, seen).error().message.find("hand-eye"), std::string::npos);
  for (const char* name : {"camera", "arm base", "tracker delay"}) {
    ASSERT_TRUE(change_of(name));
    EXPECT_EQ(name_of(*change_of(name)), name);
  }
  EXPECT_FALSE(change_of("moon"));
}

}  // namespace
}  // namespace palpate::calibration
