#include <algorithm>
#include <cmath>

#include "applications/palpation/study_parts.h"

namespace palpate::applications::palpation {
namespace {

// Published beside the searching grid: nodule, and per cent found with each of kSearchWebers (docs/theory/trainee.md).
struct Published {
  BlockNodule nodule;
  std::array<double, 5> found;
};
const std::array<Published, 6> kPublished{{{{0.015, 0.005, 10.0}, {49.0, 63.0, 75.0, 89.0, 100.0}},
                                           {{0.020, 0.010, 10.0}, {25.0, 37.0, 46.0, 60.0, 89.0}},
                                           {{0.010, 0.005, 10.0}, {17.0, 24.0, 28.0, 38.0, 74.0}},
                                           {{0.015, 0.010, 10.0}, {14.0, 19.0, 25.0, 36.0, 65.0}},
                                           {{0.010, 0.010, 10.0}, {8.0, 10.0, 11.0, 13.0, 26.0}},
                                           {{0.015, 0.020, 10.0}, {7.0, 7.0, 8.0, 9.0, 11.0}}}};
constexpr int kProfileSteps = 7;   // to 24 mm beside
constexpr int kFewerOfFreer = 20;  // its presses are chosen one by one, which takes longer
constexpr double kPercent = 100.0, kOfProfiles = 0.7;

SearchTask task_of(const StudyPlan& plan, double weber) {
  return {.weber_fraction = weber, .senses = true, .searches = plan.searches, .seed = plan.seed};
}

}  // namespace

Expected<std::vector<SearchRow>> run_searches(const StudyPlan& plan, const StudyProgress& progress) {
  std::vector<BlockNodule> nodules;
  for (const auto& published : kPublished) nodules.push_back(published.nodule);
  const double all = static_cast<double>(nodules.size()), solutions = all * kProfileSteps + 1.0;
  const auto profiles = contrast_profiles(nodules, kProfileSteps, [&](std::size_t now) {
    if (progress) progress("forces beside nodules", kOfProfiles * static_cast<double>(now) / solutions);
  });
  if (!profiles) return tl::unexpected(profiles.error());
  std::vector<SearchRow> rows;
  for (std::size_t i = 0; i < nodules.size(); ++i) {
    const ContrastProfile& profile = (*profiles)[i];
    SearchRow row{
        .nodule = nodules[i], .contrast = std::exp(profile.at(0.0)) - 1.0, .reference = kPublished[i].found};
    for (std::size_t k = 0; k < kSearchWebers.size(); ++k) {
      SearchTask task = task_of(plan, kSearchWebers[k]);
      row.grid[k] = kPercent * grid_share(profile, task);
      task.searches = std::max(1, task.searches / kFewerOfFreer);
      row.freer[k] = kPercent * freer_share(profile, task);
    }
    rows.push_back(row);
    if (progress)
      progress("searches", kOfProfiles + (1.0 - kOfProfiles) * static_cast<double>(rows.size()) / all);
  }
  return rows;
}

double numb_search_share(const StudyPlan& plan) {
  SearchTask task = task_of(plan, plan.trainee.weber_fraction);
  task.senses = false;
  return kPercent * grid_share(ContrastProfile({0.0}), task);
}

}  // namespace palpate::applications::palpation
