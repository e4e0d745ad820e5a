// palpate study flights: recorded ball flights against the simulator.
#include <memory>

#include "palpate/core/progress.h"
#include "palpate/evaluation/studies/flights_study.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/study_results.h"

namespace palpate::tools::commands {
namespace {

struct FlightsCommand {
  evaluation::studies::FlightsOptions study;
  StudyResults results;
};

Expected<void> run_flights(FlightsCommand options) {
  // Where there is nothing to study no folder is made.
  if (const auto flights = evaluation::studies::read_flights(options.study); !flights)
    return tl::unexpected(flights.error());
  if (!options.results.out.empty())
    if (auto can = evaluation::studies::can_be_written(options.results.out); !can) return can;
  Progress progress({{"flights", 1.0}});
  options.study.repeats.progress = [&progress](double share) { progress.update(share); };
  progress.begin(0);
  const auto result = evaluation::studies::study_flights(options.study);
  progress.finish();
  if (!result) return tl::unexpected(result.error());
  return give_results("flights", *result,
                      {{"flights", result->values["flights"]}, {"data", options.study.data.string()}},
                      options.results);
}

}  // namespace

void add_study_flights(CLI::App& study) {
  auto* flights = study.add_subcommand("flights", "Recorded ball flights against the simulator");
  auto options = std::make_shared<FlightsCommand>();
  flights
      ->add_option(
          "--data", options->study.data,
          "Folder of flights, *.csv with t_s,x_m,y_m,z_m, z upwards; a set is what names share before "
          "their number")
      ->required();
  flights
      ->add_option("--threads", options->study.repeats.threads, "Threads, 0 for all cores; changes no figure")
      ->check(between(0, 1024))
      ->capture_default_str();
  flights->add_option(
      "--out", options->results.out,
      "Folder for report.html, report.json, flights.json, flights.csv, errors.csv, bounces.csv");
  flights->add_option("--json", options->results.json, "Key figures, - for standard output");
  on(flights, [options] { return run_flights(*options); });
}

}  // namespace palpate::tools::commands
