// Errors of an arm's calibration on samples it has not seen, and the choice of what to free by them.
//
// Errors in metres. Deterministic. Pure functions, no thread rule.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpate/calibration/arm.h"

namespace palpate::calibration {

struct HeldOut {
  std::vector<double> means;         // per part
  std::vector<Vector3> errors;       // measured - predicted, part after part
  std::vector<std::size_t> samples;  // which sample each error is of
  double mean = 0.0;                 // of all errors
};

// The samples are cut into `regions` parts of the workspace by repeated halving across the longest side, and
// each part is predicted by a calibration that has not seen it.
Expected<HeldOut> held_out_by_region(const std::vector<device::ArmObservation>& samples,
                                     const device::ArmModel& model, const ArmOptions& options,
                                     int regions = 8);

// The same with parts drawn by the seed.
Expected<HeldOut> held_out_by_folds(const std::vector<device::ArmObservation>& samples,
                                    const device::ArmModel& model, const ArmOptions& options,
                                    std::uint64_t seed, int folds = 5);

// How a fit's errors compare with what there was to fit. A wrong unit, joints in another order or rows that
// do not belong together leave a tenth and more of the motion; an arm calibrated at all leaves a hundredth at
// most.
struct ArmMisfit {
  double error = 0.0;   // m, median
  double spread = 0.0;  // m, median distance of the measured tips from their middle
  double share() const { return error / spread; }
};
ArmMisfit arm_misfit(const ArmSolution& arm, const std::vector<device::ArmObservation>& samples);

// "gains,offsets,tip".
std::string free_text(const ArmFree& free, const device::ArmModel& model);

struct ArmChoice {
  ArmFree free;
  std::vector<std::pair<std::string, double>> tried;  // what was free, and the error in regions not seen, m
  std::string why;
};

// What lowers the error in regions not seen: beginning with gains, offsets and, where there are marker poses,
// the tip, the term that helps most is added (delay, lengths or the whole Denavit-Hartenberg rows, quadratic,
// hysteresis, as far as the samples can tell of them) as long as one lowers it by more than 1 %, and in more
// regions than not.
Expected<ArmChoice> choose_free(const std::vector<device::ArmObservation>& samples,
                                const device::ArmModel& model, const ArmOptions& options);

}  // namespace palpate::calibration
