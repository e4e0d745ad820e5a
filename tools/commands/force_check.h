// The check that an arm's forces go where they are commanded, with a person at the stylus: `calibrate forces`, and the last step of
// `calibrate all`.
//
// Ordinary thread; the loop that pushes runs in one of its own. The rig file gets the result. Errors: wrong use for no such arm;
// refused where forces stay off, in words that say why.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "palpate/calibration/session/instruction_file.h"
#include "palpate/core/expected.h"
#include "palpate/device/opened.h"
#include "palpate/rig/rig.h"

namespace palpate::tools::commands {

struct ForceArguments {
  std::string arm, rig, json;
  double weight_g = 0.0, patience_s = 120.0;
  int dead_man = 0, key_button = 0, poses = 5;
  bool yes_held = false, at_reset = false;
  std::shared_ptr<calibration::session::InstructionFile>
      instructions;  // gets each pose that is wanted; null: nothing does
};

// The weight, the key, the dead-man switch.
void add_force_options(CLI::App& command, ForceArguments& options);

// Whether this arm is given no force until it is checked: a real one whose check the rig does not hold, or not any more.
bool forces_due(const rig::Rig& rig, const device::ArmFacts& facts);

// Whether somebody can hold the key: a space bar, a button, or nobody need.
bool key_can_be_held(const ForceArguments& options);

Expected<void> check_forces_of(const ForceArguments& options);

}  // namespace palpate::tools::commands
