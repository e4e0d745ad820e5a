// The parts of `palpate study palpation`: forces, experiments, searches, and how they are told. Within this folder.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "applications/palpation/block_experiment.h"
#include "applications/palpation/block_search.h"
#include "palpate/core/json.h"
#include "palpate/experiment/fit_report.h"
#include "palpate/figures/section.h"
#include "palpate/scene/application_study.h"

namespace palpate::applications::palpation {

struct StudyPlan {
  StudiedTrainee trainee;
  int trials = 200;     // of each stimulus in each cell
  int searches = 4000;  // of each nodule and Weber fraction
  int bootstraps = 400;
  std::uint64_t seed = 1;
  bool quick = false;
};
StudyPlan study_plan_of(const scene::StudyRequest& request);

// What one experiment has found.
struct Finding {
  std::string name;
  std::optional<Varied> varied;  // none: how stiff something late feels
  experiment::Conditions conditions;
  std::vector<experiment::GroupFit> fits;  // of cells_of(conditions)
  Json staircases = Json::array();
};

// One cell of the table of searches: shares in per cent.
struct SearchRow {
  BlockNodule nodule;
  double contrast = 0.0;  // of the forces above the nodule and beside it, less 1
  std::array<double, 5> reference{}, grid{}, freer{};
};
inline constexpr std::array<double, 5> kSearchWebers{0.28, 0.22, 0.18, 0.14, 0.08};

struct StudyBar {
  std::string what;
  double value = 0.0;
  std::string expected;
  bool met = false;
};

struct StudyFindings {
  StudyPlan plan;
  std::vector<Finding> findings;
  std::vector<SearchRow> searches;
  double numb_search = 0.0;  // per cent found with the sense off
  std::vector<StudyBar> bars;
  const Finding& named(std::string_view name) const;
};

using StudyProgress = std::function<void(std::string_view what, double share)>;

// Forces at the stimuli of each series.
struct BlockForces {
  std::map<Varied, BlockPlaces> tick;
  std::optional<BlockPlaces> linear;  // over closeness
};
Expected<BlockForces> solve_block_forces(const StudyPlan& plan, const StudyProgress& progress);
std::vector<Finding> run_experiments(const StudyPlan& plan, const BlockForces& forces,
                                     const StudyProgress& progress);
Expected<std::vector<SearchRow>> run_searches(const StudyPlan& plan, const StudyProgress& progress);
double numb_search_share(const StudyPlan& plan);
std::vector<StudyBar> bars_of(const StudyFindings& findings);

scene::StudyOutcome outcome_of(const StudyFindings& findings);

}  // namespace palpate::applications::palpation
