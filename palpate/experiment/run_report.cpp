#include "palpate/experiment/run_report.h"

namespace palpate::experiment {
namespace {

std::vector<std::pair<std::string, std::string>> names_of(const Conditions& conditions,
                                                          const std::vector<std::string>& cell) {
  std::vector<std::pair<std::string, std::string>> by;
  for (std::size_t i = 0; i < cell.size(); ++i) by.emplace_back(conditions.factors[i].name, cell[i]);
  return by;
}

}  // namespace

std::vector<ObservationGroup> groups_of(const Conditions& conditions, std::span<const TrialRecord> records) {
  const auto cells = cells_of(conditions);
  std::vector<std::vector<Observation>> observations(cells.size());
  for (const auto& record : records)
    if (record.counts())
      observations.at(record.trial.cell).push_back({record.trial.stimulus, record.positive});
  std::vector<ObservationGroup> groups;
  for (std::size_t i = 0; i < cells.size(); ++i)
    groups.push_back({names_of(conditions, cells[i]), levels_of(observations[i])});
  return groups;
}

Json json_of_staircases(const ExperimentRun& run) {
  Json list = Json::array();
  const auto& conditions = run.conditions();
  const auto cells = cells_of(conditions);
  const auto tracks = static_cast<std::size_t>(conditions.tracks);
  for (std::size_t i = 0; i < run.staircases().size(); ++i) {
    const auto& staircase = run.staircases()[i];
    const auto threshold = staircase.threshold();
    Json one{{"by", Json::object()}};
    for (const auto& [factor, level] : names_of(conditions, cells[i / tracks])) one["by"][factor] = level;
    one["track"] = i % tracks + 1;
    one["share_sought"] = share_sought(conditions.rule);
    one["trials"] = staircase.trials();
    one["trials_at_limit"] = staircase.trials_at_limit();
    one["reversals"] = staircase.reversals();
    one["threshold"] = threshold ? Json(threshold->stimulus) : Json(nullptr);
    one["log_sd"] = threshold ? Json(threshold->log_sd) : Json(nullptr);
    list.push_back(std::move(one));
  }
  return list;
}

Json json_of(const ExperimentRun& run, std::span<const TrialRecord> records,
             const BootstrapOptions& options) {
  const auto& conditions = run.conditions();
  int trials = 0, practice = 0, excluded = 0;
  for (const auto& record : records)
    ++(record.counts() ? trials : record.trial.practice ? practice : excluded);
  Json json{{"name", conditions.name}, {"conditions", hash_of(conditions)},
            {"seed", run.seed()},      {"finished", run.state() == RunState::finished},
            {"trials", trials},        {"practice", practice},
            {"excluded", excluded},    {"stimulus", conditions.stimulus},
            {"groups", Json::array()}, {"staircases", json_of_staircases(run)}};
  const auto task = shape_of(conditions);
  for (const auto& group : groups_of(conditions, records))
    json["groups"].push_back(json_of(fit_group(group, task, options), task));
  return json;
}

}  // namespace palpate::experiment
