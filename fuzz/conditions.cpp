// Conditions of experiments into a run that is answered to its end.
#include "palpate/experiment/conditions.h"

#include "fuzz/check.h"
#include "palpate/experiment/experiment_run.h"

namespace palpate::fuzz {

Refusals conditions(std::string_view file) {
  Refusals refusals;
  const auto read = experiment::parse_conditions(file, "conditions.toml");
  if (!answered(read, refusals)) return refusals;
  const auto again = experiment::parse_conditions(experiment::conditions_text(*read), "again.toml");
  hold(again && experiment::hash_of(*again) == experiment::hash_of(*read),
       "conditions written are read as they were");
  experiment::ExperimentRun run(*read, 1);
  for (int i = 0; i < 2000 && run.state() != experiment::RunState::finished; ++i) {
    if (run.state() == experiment::RunState::rest) run.end_rest();
    (void)run.answer({.place = 1 + i % 2});
  }
  return refusals;
}

}  // namespace palpate::fuzz
