#include <fmt/format.h>

#include "palpate/core/json.h"
#include "tools/commands/build_info.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/doctor/doctor_evaluate.h"

namespace palpate::tools::commands {
namespace {

void print_findings(const doctor::Findings& findings) {
  std::size_t area = 0, name = 0;
  for (const auto& finding : findings) {
    area = std::max(area, finding.area.size());
    name = std::max(name, std::min<std::size_t>(finding.name.size(), 16));
  }
  for (const auto& finding : findings)
    print_line(fmt::format("{:<13}  {:<{}}  {:<{}}  {}{}{}", doctor::verdict_name(finding.verdict),
                           finding.area, area, finding.name, name, finding.value,
                           finding.remedy.empty() ? "" : "  -> ", finding.remedy));
}

Expected<void> nothing_in_the_way(const doctor::Findings& findings) {
  std::string named;
  for (const auto& finding : findings)
    if (finding.verdict == doctor::Verdict::in_the_way)
      named += fmt::format("{}{} {}", named.empty() ? "" : ", ", finding.area, finding.name);
  if (named.empty()) return {};
  return refused("doctor: in the way: {}; the lines that begin so say what to do", named);
}

}  // namespace

void add_doctor(CLI::App& program) {
  auto* command = program.add_subcommand(
      "doctor", "What works on this machine and what to do about the rest; changes nothing");
  struct Options {
    doctor::Options look;
    std::string json;
  };
  auto options = std::make_shared<Options>();
  command
      ->add_option("--json", options->json,
                   "Write the findings as JSON to FILE (- = standard output, instead of lines)")
      ->type_name("FILE");
  command->add_option("--keys", options->look.keys, "Folder of keys for tcp://; see palpate keys");
  command->add_option("--listen", options->look.listen,
                      "Address a physics server of this machine is to listen at, ipc:// or tcp://");
  command->add_option(
      "--arm", options->look.arm,
      "openhaptics[:NAME] or forcedimension[:SERIAL]: open this real arm, ask who it is, give it "
      "back; without a force");
  command->add_option("--camera", options->look.camera,
                      "A real camera as palpate graphics --camera names it: open it, wait for a picture");
  on(command, [options]() -> Expected<void> {
    options->look.version = text_of(build_info());
    options->look.plugins = plugins();
    const auto facts = doctor::gather_facts(options->look);
    if (!facts) return tl::unexpected(facts.error());
    const auto findings = doctor::evaluate(*facts);
    if (options->json != "-") print_findings(findings);
    if (!options->json.empty())
      if (auto written = write_json(options->json, doctor::to_json(findings)); !written) return written;
    return nothing_in_the_way(findings);
  });
}

}  // namespace palpate::tools::commands
