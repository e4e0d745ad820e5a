// The study as a whole, with forces by laws written here in place of the solvers': what is asked, found and told.
#include "applications/palpation/palpation_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "applications/palpation/study_parts.h"

namespace palpate::applications::palpation {
namespace {

ForceCurve hertz_times(double factor) {
  const double k = 1000.0 * factor;
  return {{0.001, 0.005}, {k * std::pow(0.001, 1.5), k * std::pow(0.005, 1.5)}};
}

BlockPlaces places_of(std::vector<double> stimuli, double most) {
  std::vector<ForceCurve> curves;
  for (const double x : stimuli) curves.push_back(hertz_times(1.0 + most * x / stimuli.back()));
  return {hertz_times(1.0), NoduleSeries(std::move(stimuli), std::move(curves))};
}

BlockForces forces_for_tests() {
  BlockForces forces;
  forces.tick.emplace(Varied::closeness, places_of({0.05, 0.1, 0.15, 0.25}, 0.5));
  forces.tick.emplace(Varied::diameter, places_of({5.0, 8.0, 12.0, 18.0}, 0.5));
  forces.tick.emplace(Varied::ratio, places_of({0.3, 0.8, 2.0, 6.0}, 0.5));
  forces.linear = places_of({0.05, 0.1, 0.15, 0.25}, 0.15);
  return forces;
}

StudyPlan small_plan(std::uint64_t seed) {
  StudyPlan plan;
  plan.trials = 100;
  plan.searches = 300;
  plan.bootstraps = 60;
  plan.seed = seed;
  plan.quick = true;
  plan.trainee.late_s = 0.05;
  return plan;
}

StudyFindings findings_of(std::uint64_t seed) {
  StudyFindings all;
  all.plan = small_plan(seed);
  all.findings = run_experiments(all.plan, forces_for_tests(), {});
  all.searches = {
      {.nodule = {}, .contrast = 0.4, .reference = {50, 60, 70, 80, 90}, .grid = {50, 60, 70, 80, 94}}};
  all.numb_search = numb_search_share(all.plan);
  all.bars = bars_of(all);
  return all;
}

bool is_met(const StudyFindings& all, std::string_view what) {
  const auto at = std::find_if(all.bars.begin(), all.bars.end(),
                               [&](const StudyBar& bar) { return bar.what.starts_with(what); });
  return at != all.bars.end() && at->met;
}

TEST(PalpationStudy, WhatMustComeOutDoesAndATableThatIsOffIsSeen) {
  const auto all = findings_of(3);
  for (const char* what :
       {"sense off: share", "sense off: searches", "late force", "late picture", "both late", "sight"})
    EXPECT_TRUE(is_met(all, what)) << what;
  EXPECT_FALSE(is_met(all, "searching grid")) << "94 beside 90 is more than three points";
  const auto& matter = all.named("matter").fits;
  ASSERT_TRUE(matter[0].fit);
  EXPECT_TRUE(!matter[1].fit || matter[1].fit->curve.threshold > matter[0].fit->curve.threshold)
      << "smaller contrasts need nearer nodules";
}

TEST(PalpationStudy, SameSeedSameFiguresAnotherSeedOthersWithinTheirIntervals) {
  const auto first = findings_of(3), again = findings_of(3), other = findings_of(4);
  EXPECT_EQ(outcome_of(first).values.dump(), outcome_of(again).values.dump());
  EXPECT_NE(outcome_of(first).values.dump(), outcome_of(other).values.dump());
  int compared = 0;
  for (const char* name : {"depth", "size", "ratio", "felt-late"})
    for (std::size_t k = 0; k < first.named(name).fits.size(); ++k) {
      const auto &a = first.named(name).fits[k].fit, &b = other.named(name).fits[k].fit;
      if (!a || !b) continue;
      ++compared;
      EXPECT_LT(std::max(a->threshold.low, b->threshold.low), std::min(a->threshold.high, b->threshold.high))
          << name << " " << k;
    }
  EXPECT_GE(compared, 8);
}

TEST(PalpationStudy, TellsOfEveryExperimentInFiguresPageAndTable) {
  const auto all = findings_of(3);
  const auto outcome = outcome_of(all);
  EXPECT_EQ(outcome.values["experiments"].size(), all.findings.size());
  EXPECT_EQ(outcome.sections.size(), all.findings.size() + 2);
  const auto& depth = outcome.values["experiments"][0]["groups"][0];
  EXPECT_NEAR(depth["threshold_depth_mm"].get<double>(), 1.0 / depth["threshold"].get<double>(), 1e-9);
  EXPECT_EQ(outcome.values["experiments"][7]["staircases"].size(), 8u) << "four of each of two cells";
  ASSERT_EQ(outcome.files.size(), 1u);
  EXPECT_NE(outcome.files[0].second.find("felt-late,late both,"), std::string::npos);
}

}  // namespace
}  // namespace palpate::applications::palpation
