// What the methods of the arm's calibration work on: checked samples, a start, and what is free.
//
// Internal to this module. SI. No thread rule.
#pragma once

#include <vector>

#include "palpate/calibration/internal/arm_problem.h"

namespace palpate::calibration {

struct ArmSetting {
  const std::vector<device::ArmObservation>* recording = nullptr;  // all of it: it tells the motion
  std::vector<std::size_t> used;                                   // which of it the samples are
  std::vector<WeighedSample> samples;
  ArmSolution nominal;                 // placed in the world by its nominal values
  bool tip_free = false;               // estimated with the rest
  bool tip_found = false;              // not given: found by the linear start
  double stated_variance = 0.0;        // m^2 per component, of whitened residuals; 0 where none is stated
  std::optional<double> stated_share;  // of the tracker's systematic error in it
};

Expected<ArmSetting> prepare_arm(const std::vector<device::ArmObservation>& observations,
                                 const device::ArmModel& model, const ArmOptions& options,
                                 const std::vector<bool>& used = {});

// What all methods free alike; `joint` adds to it.
ArmFreedom freedom_of(const ArmOptions& options, const device::ArmModel& model);

Expected<void> enough_samples(std::size_t samples, std::size_t parameters);

// The readings at the measurements' moments for this delay.
void take_motion(ArmSetting& setting, double delay_s);

Expected<Estimate<ArmSolution>> solve_joint(ArmSetting setting, const ArmOptions& options);
Expected<Estimate<ArmSolution>> solve_as_in_the_paper(const ArmSetting& setting, const ArmOptions& options);

}  // namespace palpate::calibration
