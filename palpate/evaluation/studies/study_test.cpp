#include "palpate/evaluation/studies/study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/evaluation/report/page.h"
#include "palpate/evaluation/studies/internal/arm_laboratory.h"
#include "palpate/evaluation/studies/internal/points_study.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation::studies {
namespace {

StudyOptions few(int runs, int threads) {
  StudyOptions options;
  options.runs = runs;
  options.repeats.threads = threads;
  return options;
}

double at(const std::vector<Curve>& curves, std::string_view figure, std::string_view label, double x) {
  return curve_named(curves, figure, label).at(x).mean;
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
    const auto table = read_csv(folder / "studies" / (name + ".csv"), {.text_columns = {"*"}});
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_FALSE(table->rows.empty());
  }
  EXPECT_EQ(read_csv(folder / "studies" / "clouds.csv")->rows.size(), 140u);
}

// The templates name what a report holds, and a verdict follows its figure.
TEST(Study, TheReportHoldsWhatThePageNamesAndJudgesIt) {
  const ScratchFolder folder;
  const auto done = run_studies("all", few(2, 2), folder / "studies");
  ASSERT_TRUE(done) << done.error().message;
  const Json report = Json::parse(read_file(folder / "studies" / "report.json").value());
  EXPECT_EQ(report["studies"]["clouds"]["values"], done->back().values);
  const auto page = report::page_of(report, report::PageTemplates(), folder.path());
  ASSERT_TRUE(page) << page.error().message;
  // The page of an application's own study (tools/commands/study_of_application.cpp).
  const Json own{{"kind", "study-of-application"},
                 {"title", "t"},
                 {"study", "s"},
                 {"application", "a"},
                 {"seed", 1},
                 {"quick", true},
                 {"sections", Json::array()}};
  const auto own_page = report::page_of(own, report::PageTemplates(), folder.path());
  ASSERT_TRUE(own_page) << own_page.error().message;
  auto found = page->found;
  found.insert(own_page->found.begin(), own_page->found.end());
  static const std::regex condition(R"(\{\{[#^]\s*([^}]*?)\s*\}\})");
  for (const auto& file : report::report_files()) {
    if (!file.name.starts_with("stud")) continue;
    const std::string text(file.text);
    for (std::sregex_iterator at(text.begin(), text.end(), condition), end; at != end; ++at)
      EXPECT_TRUE(found.contains((*at)[1])) << file.name << ": {{#" << (*at)[1] << "}}";
  }
  StudyResult points = done->at(2);
  ASSERT_EQ(points.name, "points");
  points.values["cramer_rao"][0]["ratio"] = 1.31;
  points.values["cramer_rao"][1]["ratio"] = 1.1;
  points.values["coverage"]["white"][0].update(Json{{"unseen_places", 0.95}, {"tip_in_marker", 0.92}});
  points.values["coverage"]["white"][1].update(Json{{"unseen_places", 0.95}, {"tip_in_marker", 0.98}});
  points.values["coverage"]["white"][2].update(Json{{"unseen_places", 0.95}, {"tip_in_marker", 0.96}});
  const auto judged = points_page(points);
  ASSERT_TRUE(judged) << judged.error().message;
  EXPECT_EQ((*judged)["cramer_rao"][0]["judged"]["verdict"], "falls short");
  EXPECT_EQ((*judged)["cramer_rao"][1]["judged"]["verdict"], "holds");
  const Json& coverage = (*judged)["coverage"];
  const auto said = [&](std::size_t row) {
    return std::pair(coverage[row]["short"].get<bool>(), coverage[row]["wide"].get<bool>());
  };
  EXPECT_EQ(said(0), std::pair(true, false));
  EXPECT_EQ(said(1), std::pair(false, true));
  EXPECT_EQ(said(2), std::pair(false, false));
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
  const auto five = curve_named(curves, "error to truth", kJoint).at(5);
  EXPECT_EQ(five.runs, 0);
  EXPECT_EQ(five.refused, 10);
  EXPECT_EQ(study->values["refused"][std::string(kJoint)][0]["refused"], 10);
  // The first offset is not found by any number of points, the others are.
  const auto error = [&](int joint, double x) {
    return curve_named(curves, "offset error", fmt::format("gamma{}, {}", joint, kEq7)).at(x).rms;
  };
  EXPECT_GT(error(1, 70), 3.0 * error(3, 70));
  // The tracker's own error is below everybody's, and near ours.
  const double floor = at(curves, "held-out error", kNoiseFloor, 70);
  EXPECT_LT(floor, at(curves, "held-out error", kEq7, 70));
  EXPECT_NEAR(at(curves, "held-out error", kJoint, 70) / floor, 1.0, 0.15);
  // A pose thrown by 10 mm would tear a plain fit away by some millimetres.
  ASSERT_EQ(study->values["outliers"].size(), 4u);
  for (const auto& row : study->values["outliers"])
    EXPECT_LT(std::abs(row["rise"].get<double>()), 0.5) << row.dump();
  // Without gains the residual of equation 7 is higher, as the paper says.
  const auto residual = [&](std::string_view what) {
    for (const auto& v : study->values["variants"])
      if (v["what"] == what) return v["train_mean_mm"].get<double>();
    return 0.0;
  };
  EXPECT_GT(residual("paper: equations 7, 8, gains held at 1"), 1.2 * residual("paper: equations 7, 8"));
}

// One arm's true numbers are those the curves end at, but for the first offset, which stays at its start.
TEST(Study, TheNumbersOfOneArmAreFound) {
  StudyResult study;
  ASSERT_TRUE(add_one_arm(study, few(8, 2)));
  for (int j = 0; j < 3; ++j) {
    const double gain = at(study.curves, "gains of one arm", fmt::format("k{}, {}", j + 1, kJoint), 70);
    EXPECT_NEAR(gain, study.values["one_arm"]["true_gains"][j].get<double>(), 0.002) << j;
    const double offset =
        at(study.curves, "offsets of one arm", fmt::format("gamma{}, {}", j + 1, kJoint), 70);
    const double expected = j == 0 ? 0.0 : study.values["one_arm"]["true_offsets_deg"][j].get<double>();
    EXPECT_NEAR(offset, expected, 0.1) << j;
  }
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
  auto world = sim::config::reference_world();
  world.tracker.white_rms = 1e-12;
  world.tracker.bias_rms = 0.0;
  world.arm.encoder_quantum = 0.0;
  LaboratorySettings settings;
  settings.samples = 20;
  settings.unused = 3;
  const auto recorded = record_laboratory(world, 4, settings);
  ASSERT_TRUE(recorded) << recorded.error().message;
  const Vector3 zeros{0.0, 0.7, -0.7};
  const auto laboratory = with_reset(*recorded, world, zeros);
  const auto& truth = laboratory.truth;
  const auto before = sim::draw_truth(world, 4);
  EXPECT_LT((truth.joints.offset - before.joints.offset - zeros).norm(), 1e-12);
  for (const auto* samples : {&laboratory.samples, &laboratory.unused}) {
    for (const auto& sample : *samples) {
      const Vector3 by_arm = (truth.X_world_base *
                              device::phantom_tip(truth.joints.apply(Vector3(sample.joints)), truth.lengths))
                                 .m;
      const Vector3 by_tracker = (*sample.marker * Point<TipMarker>{truth.tip_in_marker}).m;
      EXPECT_LT((by_arm - by_tracker).norm(), 1e-9);
    }
  }
  EXPECT_GT((laboratory.samples[0].joints - recorded->samples[0].joints).norm(), 0.5);
  for (const double error : errors_to_truth(true_solution(laboratory), laboratory)) EXPECT_LT(error, 1e-12);
}

TEST(ArmLaboratory, AWorldInWhichNothingCanBeRecordedIsRefused) {
  auto folded = sim::config::reference_world();
  folded.arm.joint_range[1] = {1.6, 1.7};
  folded.arm.joint_range[2] = {0.0, 0.05};
  auto hidden = sim::config::reference_world();
  hidden.arm.translation.z() = -1.0;  // behind the tracker
  for (const auto& world : {folded, hidden}) {
    const auto laboratory = record_laboratory(world, 1);
    ASSERT_FALSE(laboratory);
    EXPECT_EQ(laboratory.error().exit_code(), 1);
    StudyOptions options = few(1, 1);
    options.world = world;
    EXPECT_FALSE(study_points(options));
    EXPECT_FALSE(study_reset(options));
    EXPECT_FALSE(study_clouds(options));
  }
}

}  // namespace
}  // namespace palpate::evaluation::studies
