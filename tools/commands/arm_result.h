// The arm's calibration as lines for the terminal, and its place in a rig.
#pragma once

#include "palpate/calibration/findings/arm.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {

std::vector<std::string> arm_summary(const calibration::findings::ArmFindings& found);

// Into the rig's arm, what is fitted beside it kept where that is the same arm. A chain is the rig's nominal
// arm, too.
void put_into(rig::Rig& rig, const calibration::findings::ArmFindings& found, rig::Provenance from);

}  // namespace palpate::tools::commands
