#include "palpate/experiment/experiment_run.h"

#include "palpate/experiment/run_report.h"
#include "palpate/experiment/trial_file.h"
#include "python/bindings/conversions.h"
#include "python/bindings/experiment.h"

namespace palpate::python {
namespace {

using experiment::Conditions;
using experiment::ExperimentRun;
using experiment::TrialRecord;

constexpr std::array kStates{"trial", "rest", "finished"};

py::dict trial_fields(const ExperimentRun& run, const experiment::Trial& trial) {
  py::dict levels;
  const auto& factors = run.conditions().factors;
  for (std::size_t i = 0; i < factors.size(); ++i) levels[py::str(factors[i].name)] = run.levels_of(trial)[i];
  py::dict fields;
  fields["number"] = trial.number;
  fields["practice"] = trial.practice;
  fields["block"] = trial.block;
  fields["track"] = trial.track;
  fields["repeated"] = trial.repeated;
  fields["stimulus"] = trial.stimulus;
  fields["target"] = trial.target;
  fields["levels"] = levels;
  return fields;
}

experiment::Exclusion exclusion_of(const std::string& name) {
  const auto& names = experiment::kExclusionNames;
  return static_cast<experiment::Exclusion>(std::find(names.begin(), names.end(), name) - names.begin());
}

// A run with all that was answered, and the file that has it, too, until it is finished.
class Run {
 public:
  Run(const Conditions& conditions, std::uint64_t seed) : run_(conditions, seed) {}

  std::string state() const { return kStates[static_cast<std::size_t>(run_.state())]; }
  py::dict next_trial() const { return trial_fields(run_, run_.next_trial()); }
  int answered() const { return run_.answered(); }
  int most_trials() const { return run_.most_trials(); }
  void end_rest() { run_.end_rest(); }

  // Whether the answer was a positive one. In the file, where there is one, when it returns.
  bool answer(int place, double response_s, double time_s, const std::string& exclusion) {
    const auto record = run_.answer({place, response_s, time_s, exclusion_of(exclusion)});
    records_.push_back(record);
    if (file_)
      if (auto done = file_->append(record); !done) throw Failure{done.error()};
    if (run_.state() == experiment::RunState::finished) file_.reset();
    return record.positive;
  }

  void write_to(const std::string& path) {
    file_ = value_or_raise(experiment::TrialFile::begin(path, run_.conditions(), run_.seed()));
  }
  // How many answers were in it.
  std::size_t take_up(const std::string& path) {
    auto taken = value_or_raise(experiment::TrialFile::take_up(path, run_.conditions()));
    if (taken.second.seed != run_.seed())
      throw Failure{wrong_use("{}: its seed is {}, this run's is {}; give the run that seed", path,
                              taken.second.seed, run_.seed())
                        .value()};
    if (auto done = run_.take_up(taken.second.records, path); !done) throw Failure{done.error()};
    records_ = taken.second.records;
    file_ = std::move(taken.first);
    return records_.size();
  }

  py::object report(int repeats, std::uint64_t seed, double level) const {
    return object_of(unlocked([&] {
      return experiment::json_of(run_, records_, {.repeats = repeats, .seed = seed, .level = level});
    }));
  }

  // A list for each column of the file of trials.
  py::dict table() const {
    py::dict columns;
    const auto put = [&](const char* name, auto&& value_of) {
      py::list values;
      for (const auto& record : records_) values.append(value_of(record));
      columns[name] = values;
    };
    put("trial", [](const TrialRecord& r) { return r.trial.number; });
    put("practice", [](const TrialRecord& r) { return r.trial.practice; });
    put("block", [](const TrialRecord& r) { return r.trial.block; });
    put("track", [](const TrialRecord& r) { return r.trial.track; });
    put("repeated", [](const TrialRecord& r) { return r.trial.repeated; });
    put("stimulus", [](const TrialRecord& r) { return r.trial.stimulus; });
    put("target", [](const TrialRecord& r) { return r.trial.target; });
    put("answer", [](const TrialRecord& r) { return r.answer.place; });
    put("response", [](const TrialRecord& r) { return r.positive; });
    put("response_s", [](const TrialRecord& r) { return r.answer.response_s; });
    put("time_s", [](const TrialRecord& r) { return r.answer.time_s; });
    put("why", [](const TrialRecord& r) { return std::string(name_of(r.answer.exclusion)); });
    for (std::size_t i = 0; i < run_.conditions().factors.size(); ++i)
      put(run_.conditions().factors[i].name.c_str(),
          [&](const TrialRecord& r) { return run_.levels_of(r.trial)[i]; });
    return columns;
  }

 private:
  ExperimentRun run_;
  std::vector<TrialRecord> records_;
  std::optional<experiment::TrialFile> file_;
};

py::dict conditions_fields(const Conditions& conditions) {
  py::dict fields;
  const char* tasks[] = {"choice", "comparison", "yes-no"};
  fields["name"] = conditions.name;
  fields["question"] = conditions.question;
  fields["task"] = tasks[static_cast<std::size_t>(conditions.task)];
  fields["places"] = conditions.places;
  fields["stimulus"] = conditions.stimulus;
  fields["method"] = conditions.method == experiment::Method::staircase ? "staircase" : "constant-stimuli";
  fields["levels"] = conditions.levels;
  fields["repeats"] = conditions.repeats;
  py::dict factors;
  for (const auto& factor : conditions.factors) factors[py::str(factor.name)] = factor.levels;
  fields["factors"] = factors;
  fields["cells"] = experiment::cells_of(conditions);
  fields["most_trials"] = experiment::most_trials(conditions);
  fields["hash"] = experiment::hash_of(conditions);
  return fields;
}

}  // namespace

void add_experiment_runs(py::module_& module) {
  py::class_<Conditions>(module, "Conditions")
      .def("fields", &conditions_fields)
      .def("text", &experiment::conditions_text);
  module.def("read_conditions",
             [](const std::string& path) { return value_or_raise(experiment::read_conditions(path)); });
  module.def("parse_conditions", [](const std::string& content, std::string source) {
    return value_or_raise(experiment::parse_conditions(content, std::move(source)));
  });
  module.def("example_conditions", [](const std::string& method) {
    return experiment::example_conditions(method == "staircase" ? experiment::Method::staircase
                                                                : experiment::Method::constant_stimuli);
  });
  py::class_<Run>(module, "Run")
      .def(py::init<const Conditions&, std::uint64_t>())
      .def("state", &Run::state)
      .def("next_trial", &Run::next_trial)
      .def("answered", &Run::answered)
      .def("most_trials", &Run::most_trials)
      .def("end_rest", &Run::end_rest)
      .def("answer", &Run::answer)
      .def("write_to", &Run::write_to)
      .def("take_up", &Run::take_up)
      .def("report", &Run::report)
      .def("table", &Run::table);
}

}  // namespace palpate::python
