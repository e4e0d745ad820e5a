// The arm's calibration as people and programs read it: JSON keys with units, and lines for the terminal.
#pragma once

#include <optional>

#include "palpate/calibration/arm_validation.h"
#include "palpate/calibration/gimbal.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {

// What was found, and by what.
struct ArmFindings {
  std::string method, free;
  const device::ArmModel& nominal;  // the arm as its maker describes it
  const device::ArmSampleFile& samples;
  const Estimate<calibration::ArmSolution>& estimate;
  std::optional<Estimate<calibration::GimbalSolution>> gimbal;
  std::vector<Vector3> unseen, unseen_uncorrected;  // errors, m
  std::string unseen_from;                          // where those samples are from
  std::vector<double> regions;                      // held-out means, m
  std::optional<calibration::ArmChoice> choice;
  std::vector<std::string> warnings;
};

Json arm_json(const ArmFindings& found);
std::vector<std::string> arm_summary(const ArmFindings& found, const Json& json);

// Into the rig's arm, what is fitted beside it kept where that is the same arm. A chain is the rig's nominal
// arm, too.
void put_into(rig::Rig& rig, const ArmFindings& found, rig::Provenance from);

}  // namespace palpate::tools::commands
