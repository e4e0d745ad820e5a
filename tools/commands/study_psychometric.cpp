// palpate study psychometric: curves of a table of trials.
#include <memory>

#include "palpate/core/progress.h"
#include "palpate/evaluation/studies/psychometric_study.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/study_results.h"

namespace palpate::tools::commands {
namespace {

struct PsychometricCommand {
  evaluation::studies::PsychometricOptions study;
  StudyResults results;
  bool comparison = false;
};

Expected<void> run_psychometric(PsychometricCommand options) {
  if (options.comparison) options.study.task.rule = experiment::GuessRule::equals_lapse;
  if (!options.results.out.empty())
    if (auto can = evaluation::studies::can_be_written(options.results.out); !can) return can;
  Progress progress({{"curves", 1.0}});
  options.study.repeats.progress = [&progress](double share) { progress.update(share); };
  progress.begin(0);
  const auto result = evaluation::studies::study_psychometric(options.study);
  progress.finish();
  if (!result) return tl::unexpected(result.error());
  Json about{{"data", options.study.trials.string()}};
  for (const char* key : {"trials", "practice", "excluded"}) about[key] = result->values[key];
  return give_results("psychometric", *result, about, options.results);
}

}  // namespace

void add_study_psychometric(CLI::App& study) {
  auto* command = study.add_subcommand("psychometric", "Psychometric curves of a table of trials");
  auto options = std::make_shared<PsychometricCommand>();
  auto& columns = options->study.columns;
  command
      ->add_option("--trials", options->study.trials,
                   "Table (CSV): a column with the stimulus, and response (1 or 0), or positives and trials "
                   "(counts); lines "
                   "whose practice or excluded is 1 do not count")
      ->required()
      ->type_name("FILE");
  auto* guess =
      command
          ->add_option("--guess", options->study.task.guess,
                       "Share of positive answers by guessing: 0.5 for one of two places, 0 for yes or no")
          ->check(between(0.0, 0.9))
          ->capture_default_str();
  command
      ->add_flag("--comparison", options->comparison,
                 "Which of two is larger: from 0 to 1, with lapses at both ends; gives the Weber fraction")
      ->excludes(guess);
  command->add_option("--most-lapse", options->study.task.most_lapse, "Bound of the lapse rate; 0 for none")
      ->check(between(0.0, 0.2))
      ->capture_default_str();
  command->add_option("--stimulus", columns.stimulus, "Its column")
      ->capture_default_str()
      ->type_name("COLUMN");
  command->add_option("--response", columns.response, "Column of the answers")
      ->capture_default_str()
      ->type_name("COLUMN");
  command
      ->add_option("--by", columns.by, "Columns whose values split the trials, a curve for each combination")
      ->delimiter(',')
      ->type_name("COLUMN,...");
  command->add_option("--repeats", options->study.bootstrap.repeats, "Of the bootstrap")
      ->check(between(100, 100000))
      ->capture_default_str();
  command->add_option("--seed", options->study.bootstrap.seed, "Seed; the same one gives the same figures")
      ->capture_default_str();
  command->add_option("--out", options->results.out, "Folder for report.html, report.json, psychometric.json")
      ->type_name("DIR");
  command->add_option("--json", options->results.json, "Figures, - for standard output")->type_name("FILE");
  on(command, [options] { return run_psychometric(*options); });
}

}  // namespace palpate::tools::commands
