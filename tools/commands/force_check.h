// The check that an arm's forces go where they are commanded, with a person at the stylus: `calibrate forces`, and the last step of
// `calibrate all`.
//
// Ordinary thread; the loop that pushes runs in one of its own. The rig file gets the result. Errors: wrong use for no such arm;
// refused where forces stay off, in words that say why.
#pragma once

#include <string>

#include "palpate/core/expected.h"

namespace palpate::tools::commands {

struct ForceArguments {
  std::string arm, rig, json;
  double weight_g = 0.0, patience_s = 120.0;
  int dead_man = 0, key_button = 0, poses = 5;
  bool yes_held = false, at_reset = false;
};

Expected<void> check_forces_of(const ForceArguments& options);

}  // namespace palpate::tools::commands
