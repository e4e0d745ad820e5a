// palpate study flights: recorded ball flights against the simulator.
#include <memory>

#include "palpate/core/json.h"
#include "palpate/core/progress.h"
#include "palpate/evaluation/studies/flights_study.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {
namespace {

struct FlightsCommand {
  evaluation::studies::FlightsOptions study;
  std::string out, json;
};

Expected<void> run_flights(FlightsCommand options) {
  // Where there is nothing to study no folder is made.
  if (const auto flights = evaluation::studies::read_flights(options.study); !flights)
    return tl::unexpected(flights.error());
  if (!options.out.empty())
    if (auto can = evaluation::studies::can_be_written(options.out); !can) return can;
  Progress progress({{"flights", 1.0}});
  options.study.repeats.progress = [&progress](double share) { progress.update(share); };
  progress.begin(0);
  const auto result = evaluation::studies::study_flights(options.study);
  progress.finish();
  if (!result) return tl::unexpected(result.error());
  if (!options.out.empty()) {
    const std::filesystem::path out = options.out;
    if (auto done = evaluation::studies::write_study(*result, {}, out); !done) return done;
    const Json about{{"flights", result->values["flights"]}, {"data", options.study.data.string()}};
    if (auto done = evaluation::studies::write_study_report("flights", about, {*result}, out); !done)
      return done;
    notice(fmt::format("written to {}; open {}/report.html", options.out, options.out));
  }
  for (const auto& line : result->lines) print_line(line, stderr);
  if (!options.json.empty()) return write_json(options.json, result->values);
  return {};
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
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  flights->add_option(
      "--out", options->out,
      "Folder for report.html, report.json, flights.json, flights.csv, errors.csv, bounces.csv");
  flights->add_option("--json", options->json, "Key figures, - for standard output");
  on(flights, [options] { return run_flights(*options); });
}

}  // namespace palpate::tools::commands
