#include "palpate/evaluation/studies/psychometric_study.h"

#include <gtest/gtest.h>

#include <string>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation::studies {
namespace {

constexpr std::string_view kTwoPeople =
    "who,stimulus,positives,trials\neva,0.7,2,40\neva,0.9,11,40\neva,1.1,28,40\neva,1.4,39,40\n"
    "adam,0.7,20,40\nadam,0.9,20,40\nadam,1.1,20,40\nadam,1.4,20,40\n";

PsychometricOptions of(const std::filesystem::path& file) {
  PsychometricOptions options;
  options.trials = file;
  options.columns.by = {"who"};
  options.task.rule = experiment::GuessRule::equals_lapse;
  options.bootstrap.repeats = 100;
  return options;
}

TEST(PsychometricStudy, FiguresFilesAndPage) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file(folder / "t.csv", kTwoPeople));
  double progress = 0.0;
  auto options = of(folder / "t.csv");
  options.repeats.progress = [&](double share) { progress = share; };
  const auto study = study_psychometric(options);
  ASSERT_TRUE(study) << study.error().message;
  EXPECT_EQ(progress, 1.0);
  ASSERT_EQ(study->values["groups"].size(), 2u);
  EXPECT_NEAR(study->values["groups"][0]["threshold"].get<double>(), 1.0, 0.06);
  EXPECT_EQ(study->values["groups"][1]["refused"]["code"], "no_rise");
  EXPECT_EQ(study->values["trials"], 320);
  ASSERT_EQ(study->lines.size(), 2u);
  EXPECT_NE(study->lines[0].find("who eva: threshold"), std::string::npos);

  ASSERT_TRUE(can_be_written(folder / "out"));
  ASSERT_TRUE(write_study(*study, {}, folder / "out"));
  const Json about{{"data", "t.csv"}, {"trials", 320}, {"practice", 0}, {"excluded", 0}};
  const auto done = write_study_report("psychometric", about, {*study}, folder / "out");
  ASSERT_TRUE(done) << done.error().message;
  const auto html = read_file(folder / "out" / "report.html");
  ASSERT_TRUE(html);
  for (const char* told :
       {"who eva", "who adam", "no_rise", "Weber fraction", "data-name=\"fit\"", "320 trials of t.csv"})
    EXPECT_NE(html->find(told), std::string::npos) << told;
}

TEST(PsychometricStudy, WithoutAnyCurveItIsRefused) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file(folder / "t.csv", "who,stimulus,response\neva,1,1\neva,2,1\nadam,1,0\nadam,2,0\n"));
  auto options = of(folder / "t.csv");
  const auto two = study_psychometric(options);
  ASSERT_FALSE(two);
  EXPECT_EQ(two.error().exit_code(), 1);
  EXPECT_NE(two.error().message.find("no group tells a curve; who eva: "), std::string::npos)
      << two.error().message;
  options.columns.by = {"whose"};
  const auto none = study_psychometric(options);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().exit_code(), 2);
}

}  // namespace
}  // namespace palpate::evaluation::studies
