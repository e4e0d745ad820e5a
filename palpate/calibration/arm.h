// Calibration of a haptic arm against the tracker: joint correction theta = gain * psi + offset, the arm's
// place in the world, and whatever else is asked to be free (lengths or Denavit-Hartenberg rows, the tip in
// its marker, quadratic joint terms, hysteresis, the tracker's delay). Of a Cartesian arm, which states its place,
// there are no joints to correct: the smooth correction of that place is fitted, and its place in the world.
//
// Frames: World (tracker), ArmBase, TipMarker. SI and radians. Pure functions, deterministic, safe from any
// thread. Methods (Bianchi, Knoerlein, Szekely, Harders 2006, section 4.3; phi = gains, offsets, lengths):
//  - one_pass: absolute orientation R, T with phi at its nominal values, then Levenberg-Marquardt over phi;
//  - alternating: both in turn until the residual changes by less than 1e-4 of itself, at most 50 rounds;
//  - eq7: equations 7 and 8 as printed, R and T minimised inside the residual of phi;
//  - joint: one robust solve over phi, R, T and, with marker poses, the tip in the marker; whitened by the
//  samples'
//    covariances where given; outliers by Huber, then Tukey weights, scale from the median. A wide prior
//    about the nominal values (gains 0.1, offsets 1 rad, quadratic terms 0.1 per rad, hysteresis 20 mrad,
//    delay 0.2 s, lengths 20 mm, twists 10 deg, tip 100 mm, tool 500 mm, terms of a place's correction 5 mm;
//    one sigma) keeps directions still that the data do not see; these are named in Estimate::unobservable.
// The paper's methods take the tip as given (ArmOptions::tip, or the samples' measured points).
// A PHANToM's first offset trades exactly with a turn of the base: `joint` holds it at 0, all methods name
// it. Covariance (joint only) in the order of ArmSolution::parameters. Refused: fewer samples than parameters
// need, numbers that are not finite, a tip that no motion determines.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/arm_model.h"
#include "palpate/device/arm_samples.h"
#include "palpate/math/estimate.h"

namespace palpate::calibration {

enum class ArmMethod { one_pass, alternating, eq7, joint };

struct ArmFree {
  bool gains = true, offsets = true;
  bool lengths = true;     // l1, l2; of a Denavit-Hartenberg arm its a and d
  bool tip = true;         // in the marker; only `joint`, only with marker poses
  bool dh = false;         // every number of the rows, a, d, alpha and the joint offsets, and the gains
  bool correction = true;  // of the places that a Cartesian arm states; only `joint`
  // `joint` alone knows these:
  bool quadratic = false;   // theta = gain psi + quadratic psi^2 + offset
  bool hysteresis = false;  // + hysteresis * direction of the last motion; needs times
  bool delay = false;       // the measured point is where the tip was `delay` before; needs motion and times
  bool operator==(const ArmFree&) const = default;
};

struct ArmOptions {
  ArmMethod method = ArmMethod::joint;
  ArmFree free;
  std::optional<Vector3>
      tip;             // m, in the marker, from a pivot calibration: given, or the start where it is free
  bool robust = true;  // joint only
  std::optional<double> delay_start;  // s, where the search for the delay begins; else it is looked for
  // The covariance allows for a smooth systematic error of the tracker (correlated_errors.h); costs about
  // as much as the solve.
  bool allow_field = true;
};

// What the residuals say of the tracker, per component, in the units of the whitening (metres at the mean of
// the stated covariances).
struct ArmNoise {
  double sigma = 0.0;        // m
  double field_share = 0.0;  // of the variance: a smooth systematic error
  double field_reach = 0.0;  // m, over which it changes; 0 where none is seen
};

struct ArmSolution {
  device::ArmModel model;  // with the estimated lengths, rows and tool point
  Eigen::VectorXd gain, offset;
  Eigen::VectorXd quadratic, hysteresis;  // 1/rad, rad; empty where they are not modelled
  double delay_s = 0.0;                   // the tracker's stamps minus the encoders', for the same moment
  Pose<World, ArmBase> X_world_base;
  Vector3 tip_in_marker = Vector3::Zero();
  ArmNoise noise;
  bool tip_known = false;  // samples with marker poses were used with this tip
  std::vector<std::string>
      parameters;  // names of what was estimated: "gain_1", "offset_2", "base_rotation_x", ...
};

// `used` says which samples to fit (empty: all); the others still tell how the arm moved between them.
// Residuals come for all samples, `inlier` is false for those that were not used.
Expected<Estimate<ArmSolution>> calibrate_arm(const std::vector<device::ArmObservation>& samples,
                                              const device::ArmModel& model, const ArmOptions& options = {},
                                              const std::vector<bool>& used = {});

// The arm as its maker describes it, only placed in the world (and its unknown tool or tip point fitted).
Expected<Estimate<ArmSolution>> uncorrected_arm(const std::vector<device::ArmObservation>& samples,
                                                const device::ArmModel& model,
                                                const ArmOptions& options = {});

// Where the tip is when the encoders read psi and hysteresis plays no part.
Point<World> predict_tip(const ArmSolution& arm, const Eigen::VectorXd& psi);
// Where the tracker saw it.
Point<World> measured_tip(const ArmSolution& arm, const device::ArmObservation& sample);
// measured - predicted, m, one per sample; readings brought to the measurement's moment by arm.delay_s.
std::vector<Vector3> arm_errors(const ArmSolution& arm, const std::vector<device::ArmObservation>& samples);

}  // namespace palpate::calibration
