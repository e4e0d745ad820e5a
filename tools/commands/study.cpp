// palpate study: the paper's figures again, by simulation.
#include <memory>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/core/progress.h"
#include "palpate/evaluation/studies/study.h"
#include "palpate/sim/config/world_file.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"

namespace palpate::tools::commands {
namespace {

struct Options {
  evaluation::studies::StudyOptions study;
  std::string world, out, json;
};

Expected<void> run_study(const std::string& name, Options options) {
  if (!options.world.empty()) {
    const auto world = sim::config::read_world(options.world, known_applications());
    if (!world) return tl::unexpected(world.error());
    options.study.world = *world;
  }
  std::vector<Progress::Phase> phases;
  for (const auto& study : evaluation::studies::studies())
    if (name == "all" || name == study.name)
      phases.push_back({study.name, study.expected_s * options.study.runs / 1000.0});
  Progress progress(phases);
  options.study.repeats.progress = [&progress](double share) { progress.update(share); };
  const auto results = evaluation::studies::run_studies(
      name, options.study, options.out, [&](std::size_t i) { progress.begin(name == "all" ? i : 0); });
  progress.finish();
  if (!results) return tl::unexpected(results.error());
  Json json;
  for (const auto& result : *results) {
    json[result.name] = result.values;
    for (const auto& line : result.lines) print_line(line, lines_beside(options.json));
  }
  if (!options.out.empty())
    notice(fmt::format("written to {}; open {}/report.html", options.out, options.out));
  if (!options.json.empty()) return write_json(options.json, json);
  return {};
}

}  // namespace

void add_study(CLI::App& program) {
  auto* study = program.add_subcommand("study", "Figures from recordings and simulations");
  study->require_subcommand(1);
  const auto add = [&](const std::string& name, const std::string& what) {
    auto* command = study->add_subcommand(name, what);
    auto options = std::make_shared<Options>();
    command->add_option("--runs", options->study.runs, "Repeats, 1000 in the paper")
        ->check(between(1, 1000000))
        ->capture_default_str();
    command->add_option("--seed", options->study.seed, "Seed; the same one gives the same figures")
        ->capture_default_str();
    command
        ->add_option("--threads", options->study.repeats.threads,
                     "Threads, 0 for all cores; changes no figure")
        ->check(between(0, 1024))
        ->capture_default_str();
    command->add_option("--world", options->world, "World file; the reference world without one");
    command->add_option("--out", options->out,
                        "Folder for report.html, report.json, and JSON and CSV of each study");
    command->add_option("--json", options->json, "Key figures, - for standard output");
    on(command, [name, options] { return run_study(name, *options); });
  };
  for (const auto& each : evaluation::studies::studies()) add(each.name, each.what);
  add("all", "All of the paper's figures");
  add_study_flights(*study);
  add_study_psychometric(*study);
  add_study_indent(*study);
  add_studies_of_applications(*study);
}

}  // namespace palpate::tools::commands
