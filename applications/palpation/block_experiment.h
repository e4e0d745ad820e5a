// Experiments with the scripted trainee on a flat block: which of two places is stiffer, trial by trial, by the engine that
// asks people as well (palpate/experiment).
//
// Detection: one of two places has a nodule under it, the other none; positive is the right place. Comparison: one of two
// blocks without a nodule is `stimulus` times as stiff and is felt or seen late, the other one is neither; positive is that the
// late one is taken for the stiffer. What a cell of the conditions means is read off its factors:
//   sight with, without      late nothing, force, picture, both      matter neo-hookean, linear
//   sessions 0, 1, ...       force felt, off
// Deterministic by seed. One thread. Wrong use (exception): factors that are none of these.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "applications/palpation/block_forces.h"
#include "applications/palpation/press_judgement.h"
#include "palpate/experiment/conditions.h"
#include "palpate/experiment/experiment_run.h"

namespace palpate::applications::palpation {

// What is varied of the nodule; the other two are as in BlockNodule. Stimuli grow with what is easier to feel.
enum class Varied { closeness, diameter, ratio };
std::string stimulus_name(Varied varied);                 // closeness_per_mm, diameter_mm, ratio_above_1
BlockNodule nodule_with(Varied varied, double stimulus);  // closeness: 1 / depth of its top

// Forces over nodules at a row of rising stimuli; between them logarithms are interpolated over that of the stimulus.
class NoduleSeries {
 public:
  // Throws std::invalid_argument unless stimuli rise and each has its curve.
  NoduleSeries(std::vector<double> stimuli, std::vector<ForceCurve> curves);
  ForceCurve at(double stimulus) const;  // held beyond both ends
  const std::vector<double>& stimuli() const { return stimuli_; }
  const std::vector<ForceCurve>& curves() const { return curves_; }

 private:
  std::vector<double> stimuli_;
  std::vector<ForceCurve> curves_;
};

struct BlockPlaces {
  ForceCurve bare;
  NoduleSeries nodules;
};

// The trainee as the study has it, but for what a cell says otherwise.
struct StudiedTrainee {
  double weber_fraction = 0.14;  // of compliance, without sight
  double lapse_rate = 0.02;
  double late_s = 0.10;  // what comes late comes so late
  PressMotion motion;
};

struct Situation {
  Senses senses;
  AddedDelay delay;
  double weber_fraction = 0.14;
  BlockMatter matter = BlockMatter::neo_hookean;
};
Situation situation_of(const experiment::Conditions& conditions, const std::vector<std::string>& cell,
                       const StudiedTrainee& trainee);

// All trials of a run.
using Answers = std::vector<experiment::TrialRecord>;
Answers detect(experiment::ExperimentRun& run, const std::map<BlockMatter, BlockPlaces>& places,
               const StudiedTrainee& trainee);
Answers compare_late(experiment::ExperimentRun& run, const ForceCurve& bare, const StudiedTrainee& trainee);

}  // namespace palpate::applications::palpation
