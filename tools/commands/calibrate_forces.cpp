#include <memory>

#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/force_check.h"

namespace palpate::tools::commands {

void add_calibrate_forces(CLI::App& calibrate) {
  auto options = std::make_shared<ForceArguments>();
  auto* command = calibrate.add_subcommand(
      "forces", "Whether an arm's forces go where they are commanded; without it a real arm is given none");
  command
      ->add_option("--arm", options->arm, "The arm, as palpate physics --arm names it: lab, openhaptics, ...")
      ->required()
      ->type_name("URI");
  command
      ->add_option("--rig", options->rig, "Rig file with the arm's calibration; the result is written there")
      ->required()
      ->type_name("FILE");
  add_force_options(*command, *options);
  command->add_option("--poses", options->poses, "In how many poses the tip is pushed")
      ->check(between(1, 5))
      ->capture_default_str();
  command->add_option("--patience-s", options->patience_s, "How long to wait for stylus and key")
      ->check(between(1.0, 3600.0))
      ->capture_default_str();
  command->add_flag("--arm-at-reset", options->at_reset,
                    "The arm is in its reset position now: set its encoders' zero there if it is lost");
  command->add_option("--json", options->json, "Write the result as JSON to FILE (- = standard output)")
      ->type_name("FILE");
  on(command, [options] { return check_forces_of(*options); });
}

}  // namespace palpate::tools::commands
