#include "applications/palpation/palpation_study.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "applications/palpation/study_parts.h"
#include "palpate/core/units.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kOfForces = 0.45, kOfExperiments = 0.25;  // shares of the whole time
constexpr int kQuickTrials = 80, kQuickSearches = 800, kQuickBootstraps = 100;

scene::SettingSchema study_schema() {
  return {.fields = {scene::number_field("study", "trials", 200.0, {10.0, 5000.0},
                                         "Of each stimulus in each condition"),
                     scene::number_field("study", "searches", 4000.0, {100.0, 100000.0},
                                         "Of each nodule and Weber fraction"),
                     scene::number_field("study", "weber", 0.14, {0.02, 1.0},
                                         "Weber fraction of the trainee for compliance"),
                     scene::number_field("study", "late_ms", 50.0, {0.0, 150.0}, "How late is what is late",
                                         1e-3),
                     scene::number_field("study", "inwards_ms", 400.0, {200.0, 2000.0},
                                         "How long a press takes on its way in", 1e-3)},
          .relations = [](const scene::SettingValues& values) -> std::vector<scene::SettingComplaint> {
            for (const char* key : {"trials", "searches"}) {
              const double count = values.number(std::string("study.") + key);
              if (count != std::round(count)) return {{"study", key, "a whole number is expected"}};
            }
            return {};
          }};
}

StudyProgress part_of_study(const scene::StudyRequest& request, double from, double share) {
  if (!request.progress) return {};
  return [&request, from, share](std::string_view what, double of_part) {
    request.progress(what, from + share * of_part);
  };
}

Expected<scene::StudyOutcome> run_palpation_study(const scene::StudyRequest& request) {
  StudyFindings all;
  all.plan = study_plan_of(request);
  const auto forces = solve_block_forces(all.plan, part_of_study(request, 0.0, kOfForces));
  if (!forces) return tl::unexpected(forces.error());
  all.findings = run_experiments(all.plan, *forces, part_of_study(request, kOfForces, kOfExperiments));
  auto searches = run_searches(
      all.plan, part_of_study(request, kOfForces + kOfExperiments, 1.0 - kOfForces - kOfExperiments));
  if (!searches) return tl::unexpected(searches.error());
  all.searches = std::move(*searches);
  all.numb_search = numb_search_share(all.plan);
  all.bars = bars_of(all);
  return outcome_of(all);
}

}  // namespace

StudyPlan study_plan_of(const scene::StudyRequest& request) {
  const auto number = [&](const char* key) { return request.settings.number(std::string("study.") + key); };
  StudyPlan plan;
  plan.trials = static_cast<int>(number("trials"));
  plan.searches = static_cast<int>(number("searches"));
  plan.trainee.weber_fraction = number("weber");
  plan.trainee.late_s = number("late_ms");
  plan.trainee.motion.inwards_s = number("inwards_ms");
  plan.seed = request.seed;
  plan.quick = request.quick;
  if (plan.quick) {
    plan.trials = std::min(plan.trials, kQuickTrials);
    plan.searches = std::min(plan.searches, kQuickSearches);
    plan.bootstraps = kQuickBootstraps;
  }
  return plan;
}

const Finding& StudyFindings::named(std::string_view name) const {
  const auto at =
      std::find_if(findings.begin(), findings.end(), [&](const auto& f) { return f.name == name; });
  if (at == findings.end()) throw std::out_of_range("study: no finding " + std::string(name));
  return *at;
}

scene::ApplicationStudy palpation_study() {
  return {.name = "palpation",
          .summary = "What the scripted trainee can tell by feel: nodules, delays, sight, practice",
          .settings = study_schema(),
          .run = run_palpation_study};
}

}  // namespace palpate::applications::palpation
