// palpate sample: what devices, or the raw streams of a recording, show, as the tables that calibrations read.
#include "tools/commands/command.h"
#include "tools/commands/sample_kinds.h"

namespace palpate::tools::commands {

void add_sample(CLI::App& program) {
  auto* sample = program.add_subcommand(
      "sample",
      "Write the tables that `palpate calibrate` reads, from devices or from a recording's raw streams");
  sample->require_subcommand(1);
  add_sample_arm(*sample);
  add_sample_touches(*sample);
  add_sample_board(*sample);
  add_sample_pivot(*sample);
  add_sample_tools(*sample);
}

}  // namespace palpate::tools::commands
