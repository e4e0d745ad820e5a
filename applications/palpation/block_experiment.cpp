#include "applications/palpation/block_experiment.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "palpate/core/units.h"

namespace palpate::applications::palpation {
namespace {

using experiment::ExperimentRun;

// How a trainee chooses between two presses: one set of senses for each cell, so that a cell's draws are its own.
class TwoPlaces {
 public:
  TwoPlaces(const ExperimentRun& run, const StudiedTrainee& trainee)
      : trainee_(trainee), lapses_(run.seed(), "palpation/lapses") {
    const auto cells = experiment::cells_of(run.conditions());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      situations_.push_back(situation_of(run.conditions(), cells[i], trainee));
      senses_.emplace_back(sense_noise(situations_.back().weber_fraction),
                           run.seed() + 0x9e3779b97f4a7c15ull * (i + 1));
    }
  }

  const Situation& of(const experiment::Trial& trial) const { return situations_.at(trial.cell); }

  // Whether the first is taken for the stiffer one.
  bool first_is_stiffer(const experiment::Trial& trial, const PressFelt& first, const PressFelt& second) {
    auto& senses = senses_.at(trial.cell);
    const double a = senses.judged(first, of(trial).senses);
    const double b = senses.judged(second, of(trial).senses);
    if (lapses_.chance(trainee_.lapse_rate)) return lapses_.chance(0.5);
    return a > b;
  }

 private:
  StudiedTrainee trainee_;
  Random lapses_;
  std::vector<Situation> situations_;
  std::vector<TraineeSenses> senses_;
};

// Asks until the run ends: `taken` says whether the place with the stimulus was taken.
template <typename Taken>
Answers answers_of(ExperimentRun& run, Taken taken) {
  Answers answers;
  while (run.state() != experiment::RunState::finished) {
    if (run.state() == experiment::RunState::rest) {
      run.end_rest();
      continue;
    }
    const experiment::Trial trial = run.next_trial();
    const bool right = taken(trial);
    answers.push_back(run.answer({.place = right ? trial.target : 3 - trial.target}));
  }
  return answers;
}

void apply_level(const std::string& factor, const std::string& level, const StudiedTrainee& trainee,
                 Situation& situation) {
  const auto is = [&](const char* name) { return factor == name; };
  if (is("sight")) {
    situation.senses.sight = level == "with";
  } else if (is("force")) {
    situation.senses.force = level != "off";
  } else if (is("late")) {
    situation.delay.force = level == "force" || level == "both" ? trainee.late_s : 0.0;
    situation.delay.picture = level == "picture" || level == "both" ? trainee.late_s : 0.0;
  } else if (is("matter")) {
    situation.matter = level == "linear" ? BlockMatter::linear : BlockMatter::neo_hookean;
  } else if (is("sessions")) {
    situation.weber_fraction = experiment::practised_weber_fraction(std::stoi(level));
  } else {
    throw std::invalid_argument("experiment on a block: no factor " + factor + " is known");
  }
}

}  // namespace

std::string stimulus_name(Varied varied) {
  if (varied == Varied::closeness) return "closeness_per_mm";
  return varied == Varied::diameter ? "diameter_mm" : "ratio_above_1";
}

BlockNodule nodule_with(Varied varied, double stimulus) {
  BlockNodule nodule;
  if (varied == Varied::closeness) nodule.top = metres_from_mm(1.0 / stimulus);
  if (varied == Varied::diameter) nodule.diameter = metres_from_mm(stimulus);
  if (varied == Varied::ratio) nodule.ratio = 1.0 + stimulus;
  return nodule;
}

NoduleSeries::NoduleSeries(std::vector<double> stimuli, std::vector<ForceCurve> curves)
    : stimuli_(std::move(stimuli)), curves_(std::move(curves)) {
  if (stimuli_.empty() || stimuli_.size() != curves_.size() || !(stimuli_.front() > 0.0) ||
      std::adjacent_find(stimuli_.begin(), stimuli_.end(), std::greater_equal<>()) != stimuli_.end())
    throw std::invalid_argument("nodules: rising stimuli above 0, each with its forces, are expected");
}

ForceCurve NoduleSeries::at(double stimulus) const {
  const auto after = std::upper_bound(stimuli_.begin(), stimuli_.end(), stimulus);
  if (after == stimuli_.begin()) return curves_.front();
  if (after == stimuli_.end()) return curves_.back();
  const auto i = static_cast<std::size_t>(after - stimuli_.begin());
  const double share = std::log(stimulus / stimuli_[i - 1]) / std::log(stimuli_[i] / stimuli_[i - 1]);
  return ForceCurve::between(curves_[i - 1], curves_[i], share);
}

Situation situation_of(const experiment::Conditions& conditions, const std::vector<std::string>& cell,
                       const StudiedTrainee& trainee) {
  Situation situation;
  situation.weber_fraction = trainee.weber_fraction;
  for (std::size_t i = 0; i < cell.size(); ++i)
    apply_level(conditions.factors[i].name, cell[i], trainee, situation);
  return situation;
}

Answers detect(ExperimentRun& run, const std::map<BlockMatter, BlockPlaces>& places,
               const StudiedTrainee& trainee) {
  TwoPlaces trainee_at(run, trainee);
  return answers_of(run, [&](const experiment::Trial& trial) {
    const Situation& situation = trainee_at.of(trial);
    const BlockPlaces& block = places.at(situation.matter);
    const auto hard = felt_inwards(block.nodules.at(trial.stimulus), trainee.motion, situation.delay);
    const auto bare = felt_inwards(block.bare, trainee.motion, situation.delay);
    // In the order in which the places are pressed.
    return trial.target == 1 ? trainee_at.first_is_stiffer(trial, hard, bare)
                             : !trainee_at.first_is_stiffer(trial, bare, hard);
  });
}

Answers compare_late(ExperimentRun& run, const ForceCurve& bare, const StudiedTrainee& trainee) {
  TwoPlaces trainee_at(run, trainee);
  const auto standard = felt_inwards(bare, trainee.motion, {});
  return answers_of(run, [&](const experiment::Trial& trial) {
    const auto late = felt_inwards(bare.times(trial.stimulus), trainee.motion, trainee_at.of(trial).delay);
    return trial.target == 1 ? trainee_at.first_is_stiffer(trial, late, standard)
                             : !trainee_at.first_is_stiffer(trial, standard, late);
  });
}

}  // namespace palpate::applications::palpation
