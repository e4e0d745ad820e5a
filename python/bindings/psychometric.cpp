#include <map>

#include "palpate/experiment/fit_report.h"
#include "python/bindings/conversions.h"
#include "python/bindings/experiment.h"

namespace palpate::python {
namespace {

experiment::TaskShape task_of(bool comparison, double guess, double most_lapse) {
  return {.rule = comparison ? experiment::GuessRule::equals_lapse : experiment::GuessRule::fixed,
          .guess = guess,
          .most_lapse = most_lapse};
}

std::vector<experiment::Level> levels_from(const Doubles& stimuli, const Integers& positives,
                                           const Integers& trials) {
  // A stimulus that comes twice is one level; each stands once, rising.
  std::map<double, experiment::Level> levels;
  for (py::ssize_t i = 0; i < stimuli.size(); ++i) {
    auto& level = levels[stimuli.data()[i]];
    level.stimulus = stimuli.data()[i];
    level.positives += static_cast<int>(positives.data()[i]);
    level.trials += static_cast<int>(trials.data()[i]);
  }
  std::vector<experiment::Level> rising;
  for (const auto& [stimulus, level] : levels) rising.push_back(level);
  return rising;
}

// As palpate.Refused, whose code is the verdict on the data.
[[noreturn]] void refuse(const experiment::GroupFit& fit) {
  const py::object exception =
      py::module_::import("palpate._refused").attr("refusal")(fit.refusal, std::string(name_of(fit.verdict)));
  PyErr_SetObject(py::type::of(exception).ptr(), exception.ptr());
  throw py::error_already_set();
}

py::dict fit(const Doubles& stimuli, const Integers& positives, const Integers& trials, bool comparison,
             double guess, double most_lapse, double level, int repeats, std::uint64_t seed) {
  const auto task = task_of(comparison, guess, most_lapse);
  const experiment::ObservationGroup group{{}, levels_from(stimuli, positives, trials)};
  const auto found = unlocked(
      [&] { return experiment::fit_group(group, task, {.repeats = repeats, .seed = seed, .level = level}); });
  if (!found.fit) refuse(found);
  py::dict fields;
  fields["json"] = object_of(experiment::json_of(found, task));
  fields["log_threshold_sd"] = found.fit->log_threshold_sd;
  fields["log_spread_sd"] = found.fit->log_spread_sd;
  return fields;
}

py::array chances(const Doubles& stimuli, double threshold, double spread, double lapse, bool comparison,
                  double guess, double most_lapse) {
  const auto task = task_of(comparison, guess, most_lapse);
  std::vector<double> shares;
  for (const double stimulus : numbers_of(stimuli))
    shares.push_back(experiment::chance_at({threshold, spread, lapse}, task, stimulus).positive);
  return numbers_array(shares);
}

double stimulus_at(double share, double threshold, double spread, double lapse, bool comparison, double guess,
                   double most_lapse) {
  return experiment::stimulus_at({threshold, spread, lapse}, task_of(comparison, guess, most_lapse), share);
}

}  // namespace

void add_psychometric(py::module_& module) {
  module.def("fit", &fit);
  module.def("chances", &chances);
  module.def("stimulus_at", &stimulus_at);
  module.def("weber_fraction", &experiment::weber_fraction);
  module.def("spread_of_weber_fraction", &experiment::spread_of_weber_fraction);
}

}  // namespace palpate::python
