// A simulated laboratory at rest: what tracker and encoders report of poses that stand still, without the
// time between them.
//
// The same truth, tracker, LEDs, quantisation, ranges and habits (sim/pose_sampling.h) as the moving
// laboratory, at a thousandth of its cost: the studies need a thousand of them. Not in it: what motion brings
// (delays, hysteresis, a pose not quite at rest). The held tip of the pivot recording gives way by pull /
// stiffness, along the stylus and downwards, as in the moving one. World, SI. Deterministic for a seed.
// Errors: refused where the tracker sees no pose, where the arm is folded up in nearly all of its range.
#pragma once

#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/core/expected.h"
#include "palpate/evaluation/studies/internal/cramer_rao.h"
#include "palpate/sim/truth.h"

namespace palpate::evaluation::studies {

struct LaboratorySettings {
  int samples = 140;  // the paper's
  int unused = 70;    // more poses that no calibration sees
  int judged = 250;   // joint configurations at which errors to truth are taken
  int swing = 400;    // poses of the pivot recording; 0: the tip stays as the stylus' maker states it
};

struct ArmLaboratory {
  sim::Truth truth;
  std::vector<device::ArmObservation> samples, unused;
  std::vector<Vector3> sample_theta, unused_theta;  // true joint angles of these poses
  std::vector<Vector3> judged, judged_place;        // encoder readings; true tip, m, World
  Vector3 pivot_tip = Vector3::Zero();              // as the pivot calibration (algebraic) has it
  TrueArm arm() const { return {truth.lengths, truth.joints, truth.X_world_base}; }
};

Expected<ArmLaboratory> record_laboratory(const sim::config::WorldFile& world, std::uint64_t seed,
                                          const LaboratorySettings& settings = {});

// The same recording with encoders whose zeros lie `zeros` (rad) further on: the same truth otherwise, poses
// and noise, other readings.
ArmLaboratory with_reset(ArmLaboratory laboratory, const sim::config::WorldFile& world, const Vector3& zeros);

// The world with white noise alone (0.2 mm per LED): what bounds are stated for.
sim::config::WorldFile white_world(sim::config::WorldFile world);

// The arm as its maker describes it.
device::ArmModel nominal_model(const sim::config::WorldFile& world);

// What the calibration would be if it knew everything: errors against it are the tracker's alone.
calibration::ArmSolution true_solution(const ArmLaboratory& laboratory);

// Distances between estimated and true tip at the judged readings, m.
std::vector<double> errors_to_truth(const calibration::ArmSolution& arm, const ArmLaboratory& laboratory);

// The samples as the bound wants them.
std::vector<BoundSample> bound_samples(const std::vector<device::ArmObservation>& samples);

}  // namespace palpate::evaluation::studies
