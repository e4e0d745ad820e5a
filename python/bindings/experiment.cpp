// palpate._experiment: staircases, observers, psychometric curves and runs of experiments, over palpate/experiment.
#include "python/bindings/experiment.h"

#include "palpate/experiment/observer.h"
#include "python/bindings/conversions.h"

namespace palpate::python {
namespace {

experiment::StaircaseRule rule_of(const py::dict& fields) {
  experiment::StaircaseRule rule;
  rule.kind = fields["kind"].cast<std::string>() == "weighted" ? experiment::StaircaseKind::weighted
                                                               : experiment::StaircaseKind::transformed;
  rule.down_after = fields["down_after"].cast<int>();
  rule.target = fields["target"].cast<double>();
  rule.start = fields["start"].cast<double>();
  rule.lowest = fields["lowest"].cast<double>();
  rule.highest = fields["highest"].cast<double>();
  rule.step_factors = fields["step_factors"].cast<std::vector<double>>();
  rule.reversals = fields["reversals"].cast<int>();
  rule.most_trials = fields["most_trials"].cast<int>();
  rule.discard = fields["discard"].cast<int>();
  if (const auto complaint = experiment::complaint_of(rule))
    throw py::value_error(complaint->key + ": " + complaint->message);
  return rule;
}

// Where each staircase of a rule stands.
py::dict state_of(const experiment::Staircase& staircase) {
  py::dict state;
  state["finished"] = staircase.finished();
  state["stimulus"] = staircase.stimulus();
  state["trials"] = staircase.trials();
  state["trials_at_limit"] = staircase.trials_at_limit();
  state["reversals"] = numbers_array(staircase.reversals());
  state["threshold"] = threshold_of(staircase);
  return state;
}

py::array perceived(experiment::Observer& observer, const Doubles& quantities) {
  std::vector<double> logarithms;
  for (const double quantity : numbers_of(quantities)) logarithms.push_back(observer.perceived(quantity));
  return numbers_array(logarithms);
}

// Of each row, the place of the quantity that it takes for the largest.
std::vector<std::size_t> largest(experiment::Observer& observer, const Doubles& rows) {
  std::vector<std::size_t> places;
  const auto columns = static_cast<std::size_t>(rows.shape(1));
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    places.push_back(observer.largest(std::span(rows.data(i, 0), columns)));
  return places;
}

std::vector<bool> above(experiment::Observer& observer, const Doubles& quantities, double criterion) {
  std::vector<bool> answers;
  for (const double quantity : numbers_of(quantities))
    answers.push_back(observer.is_above(quantity, criterion));
  return answers;
}

}  // namespace

py::object threshold_of(const experiment::Staircase& staircase) {
  const auto threshold = staircase.threshold();
  if (!threshold) return py::none();
  return py::make_tuple(threshold->stimulus, threshold->log_sd, threshold->reversals);
}

void add_staircases(py::module_& module) {
  py::class_<experiment::Staircase>(module, "Staircase")
      .def(py::init([](const py::dict& rule) { return experiment::Staircase(rule_of(rule)); }))
      .def("state", &state_of)
      .def("answer", &experiment::Staircase::answer)
      .def("skip", &experiment::Staircase::pass);
  py::class_<experiment::InterleavedStaircases>(module, "InterleavedStaircases")
      .def(py::init([](const std::vector<py::dict>& rules, std::uint64_t seed) {
        std::vector<experiment::StaircaseRule> all;
        for (const auto& rule : rules) all.push_back(rule_of(rule));
        return experiment::InterleavedStaircases(std::move(all), seed);
      }))
      .def("finished", &experiment::InterleavedStaircases::finished)
      .def("next", &experiment::InterleavedStaircases::next)
      .def("answer", &experiment::InterleavedStaircases::answer)
      .def("states", [](const experiment::InterleavedStaircases& staircases) {
        std::vector<py::dict> states;
        for (const auto& one : staircases.all()) states.push_back(state_of(one));
        return states;
      });
  module.def("share_sought", [](const py::dict& rule) { return experiment::share_sought(rule_of(rule)); });
  py::class_<experiment::Observer>(module, "Observer")
      .def(py::init([](double weber_fraction, double lapse_rate, std::uint64_t seed) {
        return experiment::Observer({weber_fraction, lapse_rate}, seed);
      }))
      .def("perceived", &perceived)
      .def("largest", &largest)
      .def("is_above", &above);
  module.def("practised_weber_fraction", &experiment::practised_weber_fraction);
}

}  // namespace palpate::python

PYBIND11_MODULE(_experiment, module) {
  palpate::python::raise_failures();
  palpate::python::add_staircases(module);
  palpate::python::add_psychometric(module);
  palpate::python::add_experiment_runs(module);
}
