// The arm's calibration as lines for the terminal, and its place in a rig.
#pragma once

#include "palpate/calibration/findings/arm.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {

// --rest-readings: what the arm reads at rest, in the file's unit (deg, of an arm that states its place mm). Wrong use where
// they are not one per joint.
Expected<device::JointVector> rest_readings_of(const std::vector<double>& given,
                                               const device::ArmModel& model);

std::vector<std::string> arm_summary(const calibration::findings::ArmFindings& found);

// Into the rig's arm, what is fitted beside it kept where that is the same arm. A chain is the rig's nominal
// arm, too.
void put_into(rig::Rig& rig, const calibration::findings::ArmFindings& found, rig::Provenance from);

}  // namespace palpate::tools::commands
