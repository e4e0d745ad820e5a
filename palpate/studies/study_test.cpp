#include "palpate/studies/study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/studies/arm_laboratory.h"
#include "palpate/studies/points_study.h"
#include "tests/scratch_folder.h"

namespace palpate {
namespace {

StudyOptions few(int runs, int threads) {
  StudyOptions options;
  options.runs = runs;
  options.repeats.threads = threads;
  return options;
}

double at(const std::vector<Curve>& curves, std::string_view figure, std::string_view label, double x) {
  for (const auto& point : curve_named(curves, figure, label).points)
    if (point.x == x) return point.y.mean;
  throw std::invalid_argument("no such point");
}

TEST(Study, SummariesAreThoseOfTheNumbersAlone) {
  const auto s = summary_of({1.0, 2.0, std::nan(""), 6.0});
  EXPECT_EQ(s.runs, 3);
  EXPECT_EQ(s.refused, 1);
  EXPECT_DOUBLE_EQ(s.mean, 3.0);
  EXPECT_DOUBLE_EQ(s.sd, std::sqrt(7.0));
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(41.0 / 3.0));
  EXPECT_DOUBLE_EQ(s.median, 2.0);
  EXPECT_TRUE(std::isnan(summary_of({}).mean));
}

TEST(Study, TheSameNumbersOnOneThreadAndOnTwo) {
  for (const auto& study : studies()) {
    const auto one = study.run(few(2, 1)), two = study.run(few(2, 2));
    ASSERT_TRUE(one) << one.error().message;
    ASSERT_TRUE(two) << two.error().message;
    EXPECT_EQ(curves_csv(one->curves), curves_csv(two->curves)) << study.name;
    EXPECT_EQ(one->values.dump(), two->values.dump()) << study.name;
    StudyOptions other = few(2, 2);
    other.seed = 2;
    EXPECT_NE(study.run(other)->values.dump(), one->values.dump()) << study.name;
  }
}

TEST(Study, EverythingIsWrittenAndReadsBack) {
  const ScratchFolder folder;
  const auto done = run_studies("all", few(2, 2), folder / "studies");
  ASSERT_TRUE(done) << done.error().message;
  const auto page = read_file(folder / "studies" / "report.html");
  ASSERT_TRUE(page);
  for (const auto& study : studies()) {
    const auto name = std::string(study.name);
    EXPECT_NE(page->find("id=\"" + name + "\""), std::string::npos) << name;
    const auto json = read_file(folder / "studies" / (name + ".json"));
    ASSERT_TRUE(json) << name;
    EXPECT_EQ(Json::parse(*json)["runs"], 2);
    if (name == "clouds") continue;  // its points are in a file of their own
    const auto table = read_csv(folder / "studies" / (name + ".csv"), {.text_columns = {"*"}});
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_FALSE(table->rows.empty());
  }
  EXPECT_EQ(read_csv(folder / "studies" / "clouds-points.csv")->rows.size(), 140u);
}

TEST(Study, WhatMakesNoSenseIsRefusedBeforeAnythingRuns) {
  const ScratchFolder folder;
  const auto never = [](std::size_t) { FAIL(); };
  const auto unknown = run_studies("pints", few(1, 1), "", never);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().exit_code(), 2);
  EXPECT_NE(unknown.error().message.find("points"), std::string::npos);
  for (const int runs : {0, -5, 2000000}) {
    const auto none = run_studies("points", few(runs, 1), "", never);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().exit_code(), 2);
  }
  ASSERT_TRUE(write_file(folder / "file", "x"));
  EXPECT_FALSE(run_studies("points", few(1, 1), folder / "file", never));
  EXPECT_FALSE(run_studies("points", few(1, 1), folder / "file" / "below", never));
}

TEST(Study, MorePointsHelpAndTheJointSolveBeatsThePaper) {
  const auto study = study_points(few(10, 2));
  ASSERT_TRUE(study) << study.error().message;
  const auto& curves = study->curves;
  EXPECT_LT(at(curves, "error to truth", kJoint, 70), at(curves, "error to truth", kJoint, 15));
  for (const auto method : {kOnePass, kAlternating, kEq7})
    EXPECT_LT(at(curves, "error to truth", kJoint, 70), 0.5 * at(curves, "error to truth", method, 70))
        << method;
  // Five points are too few for the fourteen unknowns of the joint solve.
  EXPECT_EQ(curve_named(curves, "error to truth", kJoint).points.front().y.runs, 0);
  // The first offset is not found by any number of points, the others are.
  const auto error = [&](int joint, double x) {
    for (const auto& p : curve_named(curves, "offset error", fmt::format("gamma{}, {}", joint, kEq7)).points)
      if (p.x == x) return p.y.rms;
    return 0.0;
  };
  EXPECT_GT(error(1, 70), 3.0 * error(3, 70));
}

TEST(Study, OddResetsEndAtTheSameError) {
  const auto study = study_reset(few(3, 2));
  ASSERT_TRUE(study) << study.error().message;
  EXPECT_LT(study->values["ours_spread"].get<double>(),
            0.1);  // three laboratories only; the bar is 5 % of 1000
}

TEST(Study, TheCloudsComeTogether) {
  const auto study = study_clouds(few(1, 1));
  ASSERT_TRUE(study);
  const auto before = study->values["before"], after = study->values["after"];
  EXPECT_GT(before["mean_mm"].get<double>(), 5.0 * after["mean_mm"].get<double>());
  EXPECT_GT(before["radial_sd_mm"].get<double>(), 5.0 * after["radial_sd_mm"].get<double>());
}

TEST(ArmLaboratory, ExactDevicesAgreeWithTheTruthAndAResetMovesTheReadings) {
  auto world = sim::reference_world();
  world.tracker.white_rms = 1e-12;
  world.tracker.bias_rms = 0.0;
  world.arm.encoder_quantum = 0.0;
  LaboratorySettings settings;
  settings.samples = 20;
  settings.reset = {0.0, 0.7, -0.7};
  const auto laboratory = record_laboratory(world, 4, settings);
  ASSERT_TRUE(laboratory) << laboratory.error().message;
  const auto& truth = laboratory->truth;
  const auto before = sim::draw_truth(world, 4);
  EXPECT_LT((truth.joints.offset - before.joints.offset - settings.reset).norm(), 1e-12);
  for (const auto& sample : laboratory->samples) {
    const Vector3 by_arm =
        (truth.X_world_base * phantom_tip(truth.joints.apply(Vector3(sample.joints)), truth.lengths)).m;
    const Vector3 by_tracker = (*sample.marker * Point<TipMarker>{truth.tip_in_marker}).m;
    EXPECT_LT((by_arm - by_tracker).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace palpate
