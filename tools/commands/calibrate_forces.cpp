#include <memory>

#include "tools/commands/command.h"
#include "tools/commands/force_check.h"

namespace palpate::tools::commands {

void add_calibrate_forces(CLI::App& calibrate) {
  auto options = std::make_shared<ForceArguments>();
  auto* command = calibrate.add_subcommand(
      "forces", "Whether an arm's forces go where they are commanded; without it a real arm is given none");
  command->add_option("--arm", options->arm, "The arm: lab, openhaptics or openhaptics:NAME")
      ->required()
      ->type_name("URI");
  command
      ->add_option("--rig", options->rig, "Rig file with the arm's calibration; the result is written there")
      ->required()
      ->type_name("FILE");
  command
      ->add_option(
          "--weight-g", options->weight_g,
          "A known weight that the arm lifts at the end, g: tells the size; without it the peak stays at 1 N")
      ->check(CLI::Range(5.0, 90.0));
  command
      ->add_option("--dead-man", options->dead_man,
                   "From then on forces only while this button of the stylus is held, counted from 1")
      ->check(CLI::Range(1, 32));
  command
      ->add_option(
          "--key-button", options->key_button,
          "The key to be held during the check is this button of the stylus, not the terminal's space bar")
      ->check(CLI::Range(1, 32));
  command->add_flag("--yes-held", options->yes_held,
                    "Count the key as held throughout: for scripts, not for people");
  command->add_option("--poses", options->poses, "In how many poses the tip is pushed")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
  command->add_option("--patience-s", options->patience_s, "How long to wait for stylus and key")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  command->add_flag("--arm-at-reset", options->at_reset,
                    "The arm is in its reset position now: set its encoders' zero there if it is lost");
  command->add_option("--json", options->json, "Write the result as JSON to FILE (- = standard output)")
      ->type_name("FILE");
  on(command, [options] { return check_forces_of(*options); });
}

}  // namespace palpate::tools::commands
