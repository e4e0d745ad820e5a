#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "applications/palpation/study_parts.h"
#include "palpate/experiment/run_report.h"

namespace palpate::applications::palpation {
namespace {

using experiment::Conditions;
using experiment::Factor;

// Depths of a nodule's top, mm, the deepest first; diameters, mm; ratios above 1.
const std::vector<double> kTops{22.0, 16.0, 12.0, 9.0, 7.0, 5.0, 3.5}, kQuickTops{18.0, 11.0, 7.0, 4.0},
    kLinearTops{16.0, 9.0, 5.0, 3.5}, kDiameters{4.0, 6.0, 8.0, 11.0, 15.0, 20.0},
    kQuickDiameters{5.0, 8.0, 12.0, 18.0}, kRatios{0.15, 0.3, 0.6, 1.2, 2.5, 6.0},
    kQuickRatios{0.3, 0.8, 2.0, 6.0}, kLateRatios{0.4, 0.55, 0.7, 0.85, 1.0, 1.2, 1.45, 1.8, 2.4};

std::vector<double> closeness_of(const std::vector<double>& tops_mm) {
  std::vector<double> stimuli;
  for (const double top : tops_mm) stimuli.push_back(1.0 / top);
  return stimuli;
}

std::vector<double> stimuli_of(Varied varied, bool quick) {
  if (varied == Varied::closeness) return closeness_of(quick ? kQuickTops : kTops);
  if (varied == Varied::diameter) return quick ? kQuickDiameters : kDiameters;
  return quick ? kQuickRatios : kRatios;
}

// What of an experiment is not the same in all.
struct Asked {
  std::string name;
  std::optional<Varied> varied;
  std::vector<Factor> factors;
  experiment::Method method = experiment::Method::constant_stimuli;
};

std::vector<Asked> all_asked() {
  const Factor sight{"sight", {"with", "without"}}, late{"late", {"nothing", "force", "picture", "both"}},
      matter{"matter", {"neo-hookean", "linear"}}, sessions{"sessions", {"0", "2", "4", "6"}},
      off{"force", {"off"}};
  return {{"depth", Varied::closeness, {sight}, {}},
          {"size", Varied::diameter, {sight}, {}},
          {"ratio", Varied::ratio, {sight}, {}},
          {"late", Varied::closeness, {late}, {}},
          {"matter", Varied::closeness, {matter}, {}},
          {"sessions", Varied::closeness, {sessions}, {}},
          {"sense-off", Varied::closeness, {off, sight}, {}},
          {"staircase", Varied::closeness, {sight}, experiment::Method::staircase},
          {"felt-late", std::nullopt, {late}, {}}};
}

Conditions asked_conditions(const Asked& asked, const StudyPlan& plan, const std::vector<double>& stimuli) {
  Conditions conditions;
  conditions.name = "palpation-" + asked.name;
  conditions.question = asked.varied ? "Under which of the two is a nodule?" : "Which of the two is stiffer?";
  conditions.task = asked.varied ? experiment::TaskKind::choice : experiment::TaskKind::comparison;
  conditions.places = 2;
  conditions.stimulus = asked.varied ? stimulus_name(*asked.varied) : "stiffness_ratio";
  conditions.method = asked.method;
  conditions.levels = stimuli;
  conditions.repeats = plan.trials;
  conditions.factors = asked.factors;
  if (asked.method == experiment::Method::staircase) {
    conditions.tracks = plan.quick ? 4 : 8;
    conditions.rule = {.start = stimuli.back(),
                       .lowest = stimuli.front(),
                       .highest = stimuli.back(),
                       .step_factors = {1.3, 1.2, 1.1},
                       .reversals = 16,
                       .most_trials = 200};
  }
  return conditions;
}

std::map<BlockMatter, BlockPlaces> places_for(const Asked& asked, const BlockForces& forces) {
  std::map<BlockMatter, BlockPlaces> places;
  places.emplace(BlockMatter::neo_hookean, forces.tick.at(*asked.varied));
  if (*asked.varied == Varied::closeness && forces.linear)
    places.emplace(BlockMatter::linear, *forces.linear);
  return places;
}

Finding found_by(const Asked& asked, const StudyPlan& plan, const BlockForces& forces) {
  const auto stimuli = asked.name == "matter" ? forces.linear->nodules.stimuli()
                       : asked.varied         ? stimuli_of(*asked.varied, plan.quick)
                                              : kLateRatios;
  Finding finding;
  finding.name = asked.name;
  finding.varied = asked.varied;
  finding.conditions = asked_conditions(asked, plan, stimuli);
  experiment::ExperimentRun run(finding.conditions,
                                Random(plan.seed, "palpation/study/" + asked.name).bits());
  const Answers answers = asked.varied
                              ? detect(run, places_for(asked, forces), plan.trainee)
                              : compare_late(run, forces.tick.at(Varied::closeness).bare, plan.trainee);
  const auto task = experiment::shape_of(finding.conditions);
  for (const auto& group : experiment::groups_of(finding.conditions, answers))
    finding.fits.push_back(
        experiment::fit_group(group, task, {.repeats = plan.bootstraps, .seed = plan.seed}));
  if (asked.method == experiment::Method::staircase) finding.staircases = experiment::json_of_staircases(run);
  return finding;
}

using Done = std::function<void(std::size_t)>;

Expected<BlockPlaces> solved_places(Varied varied, const std::vector<double>& stimuli, BlockMatter matter,
                                    const Done& done) {
  std::vector<BlockNodule> nodules;
  for (const double stimulus : stimuli) nodules.push_back(nodule_with(varied, stimulus));
  auto curves = forces_on_block(nodules, matter, done);
  if (!curves) return tl::unexpected(curves.error());
  const ForceCurve bare = curves->front();
  curves->erase(curves->begin());
  return BlockPlaces{bare, NoduleSeries(stimuli, std::move(*curves))};
}

}  // namespace

Expected<BlockForces> solve_block_forces(const StudyPlan& plan, const StudyProgress& progress) {
  const auto linear = closeness_of(plan.quick ? std::vector<double>{} : kLinearTops);
  constexpr std::array<Varied, 3> kAll{Varied::closeness, Varied::diameter, Varied::ratio};
  std::size_t all = linear.empty() ? 0 : linear.size() + 1, before = 0;
  for (const Varied varied : kAll) all += stimuli_of(varied, plan.quick).size() + 1;
  const auto done = [&](std::size_t now) {
    if (progress) progress("forces", static_cast<double>(before + now) / static_cast<double>(all));
  };
  BlockForces forces;
  for (const Varied varied : kAll) {
    const auto stimuli = stimuli_of(varied, plan.quick);
    auto places = solved_places(varied, stimuli, BlockMatter::neo_hookean, done);
    if (!places) return tl::unexpected(places.error());
    forces.tick.emplace(varied, std::move(*places));
    before += stimuli.size() + 1;
  }
  if (linear.empty()) return forces;
  auto places = solved_places(Varied::closeness, linear, BlockMatter::linear, done);
  if (!places) return tl::unexpected(places.error());
  forces.linear = std::move(*places);
  return forces;
}

std::vector<Finding> run_experiments(const StudyPlan& plan, const BlockForces& forces,
                                     const StudyProgress& progress) {
  auto asked = all_asked();
  if (!forces.linear) std::erase_if(asked, [](const Asked& one) { return one.name == "matter"; });
  std::vector<Finding> findings;
  for (const auto& one : asked) {
    findings.push_back(found_by(one, plan, forces));
    if (progress)
      progress(one.name, static_cast<double>(findings.size()) / static_cast<double>(asked.size()));
  }
  return findings;
}

}  // namespace palpate::applications::palpation
