// An arm calibrated and judged: what calibrate_arm finds in samples, how well it predicts samples that it has not seen,
// and what is to be thought of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "palpate/calibration/arm_validation.h"
#include "palpate/calibration/findings/findings.h"
#include "palpate/calibration/gimbal.h"

namespace palpate::calibration::findings {

inline constexpr int kFolds = 5;

struct ArmTask {
  device::ArmModel nominal;       // as its maker describes it
  device::ArmSampleFile samples;  // `source` names them in words
  ArmMethod method = ArmMethod::joint;
  std::string
      free;  // what is estimated, "gains,offsets,tip", as --free says it; "auto"; empty: what suits the samples
  std::optional<Vector3> tip;                 // m, in the marker, from a pivot calibration
  std::optional<device::ArmSampleFile> test;  // to judge by; none: five folds of the samples
  std::uint64_t seed = 1;                     // draws the folds
  // The result has to stand in a rig file, which holds no quadratic or hysteresis terms.
  bool for_rig = false;
};

struct ArmFindings {
  ArmMethod method = ArmMethod::joint;
  std::string free;
  device::ArmModel nominal;
  device::ArmSampleFile samples;  // repeats left out
  Estimate<ArmSolution> estimate;
  std::optional<Estimate<GimbalSolution>> gimbal;
  std::vector<Vector3> unseen, unseen_uncorrected;  // errors, m
  std::string unseen_from;                          // where those samples are from
  std::vector<Vector3> unseen_of_fitting;  // of them without those that the fit left out; empty with a test's
  std::vector<double> regions;             // held-out means, m
  std::optional<ArmChoice> choice;
  std::vector<std::string> warnings;
  Json json;
};

// Refused, too, where half of the samples lie so far off that they are not this arm's. Messages name the samples.
Expected<ArmFindings> find_arm(ArmTask task);

const char* name_of(ArmMethod method);  // "one-pass"

}  // namespace palpate::calibration::findings
