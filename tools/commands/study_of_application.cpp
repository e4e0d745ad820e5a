// palpate study NAME of the applications' own studies (palpate/scene/application_study.h).
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "palpate/core/progress.h"
#include "palpate/evaluation/report/page.h"
#include "palpate/scene/setting_text.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/commands/study_results.h"

namespace palpate::tools::commands {
namespace {

using scene::SettingField;
using scene::SettingKind;

struct ApplicationStudyCommand {
  scene::ApplicationStudy study;
  std::string application;
  std::uint64_t seed = 1;
  bool quick = false;
  StudyResults results;
  std::map<std::string, std::string> said;  // by the setting's name; empty: nothing was said
};

std::string option_name(const SettingField& field) {
  std::string name = "--" + field.key;
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

std::string initial_text(const SettingField& field) {
  if (const auto* text = std::get_if<std::string>(&field.initial)) return *text;
  return fmt::format("{}", fmt::join(std::get<std::vector<double>>(field.initial), ","));
}

Expected<scene::SettingValues> settings_of(const ApplicationStudyCommand& command) {
  scene::SettingValues values(command.study.settings);
  for (const auto& field : command.study.settings.fields) {
    const std::string& said = command.said.at(field.name());
    if (said.empty()) continue;
    auto value = scene::value_of_text(field, said, option_name(field));
    if (!value) return tl::unexpected(value.error());
    values.set(field.name(), std::move(*value));
  }
  auto fine = scene::check(command.study.settings, values);
  if (fine) return values;
  Error complaint = fine.error();  // names the setting, which a person knows as an option
  for (const auto& field : command.study.settings.fields)
    if (const std::string named = field.name() + ": "; complaint.message.starts_with(named))
      complaint.message = option_name(field) + ": " + complaint.message.substr(named.size());
  return tl::unexpected(complaint);
}

Expected<scene::StudyOutcome> outcome_of(const ApplicationStudyCommand& command,
                                         const scene::StudyRequest& request) {
  try {
    return command.study.run(request);
  } catch (const std::exception& thrown) {
    return refused("{}: {}", command.study.name, excerpt(thrown.what(), 400));
  }
}

Expected<void> run_application_study(const ApplicationStudyCommand& command) {
  const auto settings = settings_of(command);
  if (!settings) return tl::unexpected(settings.error());
  if (!command.results.out.empty())
    if (auto can = evaluation::studies::can_be_written(command.results.out); !can) return can;
  scene::StudyRequest request{.settings = *settings, .seed = command.seed, .quick = command.quick};
  std::optional<Progress> progress;
  if (!command.results.quiet) {
    progress.emplace(std::vector<Progress::Phase>{{command.study.name, 1.0}});
    progress->begin(0);
    request.progress = [&progress](std::string_view what, double share) {
      progress->say(std::string(what));
      progress->update(share);
    };
  }
  auto outcome = outcome_of(command, request);
  if (progress) progress->finish();
  if (!outcome) return tl::unexpected(outcome.error());
  evaluation::studies::StudyResult result;
  result.name = command.study.name;
  result.values = std::move(outcome->values);
  result.files = std::move(outcome->files);
  result.lines = std::move(outcome->lines);
  result.page = {{"sections", evaluation::report::json_of(outcome->sections)}};
  const Json about{
      {"title", command.study.summary}, {"study", command.study.name}, {"application", command.application},
      {"seed", command.seed},           {"quick", command.quick},      {"sections", result.page["sections"]}};
  return give_results("study-of-application", result, about, command.results);
}

void add_one(CLI::App& study, const std::string& application, const scene::ApplicationStudy& of) {
  const auto known = study.get_subcommands(std::function<bool(CLI::App*)>{});
  if (std::any_of(known.begin(), known.end(),
                  [&](const CLI::App* one) { return one->get_name() == of.name; }))
    throw std::invalid_argument(
        fmt::format("application '{}': its study {} has the name of one that the program has; choose another",
                    application, of.name));
  auto* command = study.add_subcommand(of.name, of.summary);
  auto options = std::make_shared<ApplicationStudyCommand>();
  options->study = of;
  options->application = application;
  for (const auto& field : of.settings.fields) {
    auto& said = options->said[field.name()];
    auto* option =
        command->add_option(option_name(field), said, field.help)->default_str(initial_text(field));
    if (field.kind == SettingKind::choice) option->check(one_of(field.choices));
  }
  command->add_option("--seed", options->seed, "Seed; the same one gives the same figures")
      ->capture_default_str();
  command->add_flag("--quick", options->quick, "Fewer trials: within a minute");
  command->add_flag("--quiet", options->results.quiet, "Nothing on standard error but what goes wrong");
  command
      ->add_option("--out", options->results.out, "Folder for report.html, report.json and the study's files")
      ->type_name("DIR");
  command->add_option("--json", options->results.json, "Figures, - for standard output")->type_name("FILE");
  on(command, [options] { return run_application_study(*options); });
}

}  // namespace

void add_studies_of_applications(CLI::App& study) {
  for (const auto& application : known_applications().specs())
    for (const auto& each : application.studies) add_one(study, application.name, each);
}

}  // namespace palpate::tools::commands
