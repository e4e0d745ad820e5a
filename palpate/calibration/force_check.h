// Whether an arm's forces go where they are commanded: judged by how a hand that holds the stylus lightly gives way.
//
// In several poses the tip is pushed along each axis, both ways. A hand is a soft spring: while the force f rises and
// falls slowly the tip goes by A f, and
//
//   A = C T,   T = (J^T)^+ S J^T
//
// C is the hand's compliance (symmetric, positive), J the calibrated Jacobian of the tip (3 x n), and S what the motors
// make of the torques that were commanded: the identity where all is well, -1 where a joint is mirrored, 0 where it has
// no power, a permutation where joints are exchanged. Nobody knows C. It is taken as c exp(E + d_k): E the hand's own
// anisotropy, the same in all poses, d_k what changes from pose to pose; both are normal with the deviations of
// ForceCheckSettings. Each explanation (joints or axes in this or that order, with gains of either sign) is fitted by
// least squares with these as priors, and the explanations' costs are compared.
//
// What can be told: signs and exchanges from one pose, since no hand gives way against the force that pushes it. The
// ratio of two joints' gains only up to the hand's anisotropy; poses in which a joint pushes another way narrow it down.
// An arm that states its place has none of these: of it no ratio is told, only signs and order.
// What cannot: the size of all forces together, which a stiffer hand imitates; a known weight tells it
// (gain_of_weight).
//
// ArmBase axes, N, m, s. Pure functions, any thread. They allocate.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/so3.h"

namespace palpate::calibration {

// --- one ramp

struct RampSample {
  double time = 0.0;                       // s
  double force = 0.0;                      // N, commanded, along the ramp's direction
  Vector3 displacement = Vector3::Zero();  // m, of the tip
};

struct RampResponse {
  Vector3 direction = Vector3::UnitX();  // of the force, length 1
  Vector3 compliance = Vector3::Zero();  // m/N: A direction, the part in phase with the force
};

// By least squares of displacement = c0 + c1 t + A u f + b df/dt: a hand that drifts, and one that lags, are no
// compliance. None where the samples cannot tell (fewer than 8, no force).
std::optional<RampResponse> ramp_response(const Vector3& direction, std::span<const RampSample> samples);

// --- all ramps

struct ForcePose {
  Eigen::Matrix3Xd jacobian;  // of the tip, m/rad, columns: motors' joints
  std::vector<RampResponse> ramps;
};

struct ForceCheckSettings {
  // The arm states its place, and the columns of the Jacobian are its axes: no ratio is told, nor asked for.
  bool states_place = false;
  // Of the logarithm of the hand's compliance, per component. 0.35 makes a hand three times as soft in its softest
  // direction as in its stiffest an ordinary one. Limbs are so: Mussa-Ivaldi, Hogan, Bizzi (1985), "Neural, mechanical,
  // and geometric factors subserving arm posture in humans", find stiffness ellipses several times as long as wide.
  double hand_anisotropy = 0.35;
  // From pose to pose: shape, and how firm the grip is.
  double hand_change = 0.10, grip_change = 0.25;
  // Beside the scatter of the ramps: a hand is no perfect spring. Of the compliance.
  double hand_nonlinearity = 0.02;
  // Largest ratio of two joints' gains that counts as agreement. It turns a force by at most
  // asin((r - 1) / (r + 1)) = 16.6 degrees, less than the 18 from which on people tell directions of force apart
  // (Barbagli, Salisbury, Ho, Spence, Tan 2006, "Haptic discrimination of force direction and the influence of visual
  // information").
  double agreed_ratio = 1.8;
  // Difference of costs (minus twice the logarithm of the likelihood) from which one explanation counts as the
  // better: odds of 10^4.
  double clearly_better = 18.4;
};

enum class ForceVerdict : std::uint8_t {
  agreed,
  axis_mirrored,
  axes_exchanged,
  joint_mirrored,
  joints_exchanged,
  joint_without_power,
  ratio_off,          // of joints, or of axes
  too_little_motion,  // blocked, or no motor has power
  restless_hand,      // it moved by itself more than by the force
  undetermined,       // the poses are too much alike
  unexplained         // no explanation fits
};
std::string_view name_of(ForceVerdict verdict);

struct ForceCheck {
  ForceVerdict verdict = ForceVerdict::undetermined;
  std::string words;                  // one line: what was found, and what to do
  bool ratios_told = true;            // else agreed to in signs and order alone
  int first = -1, second = -1;        // joint or axis that is at fault, counted from 0
  Eigen::VectorXd joint_gains;        // beside their median; as if joints were not exchanged
  Eigen::MatrixXd covariance;         // of joint_gains
  Matrix3 map = Matrix3::Identity();  // felt over commanded force in the first pose, of mean gain 1
  Eigen::Matrix<double, 9, 9> map_covariance = Eigen::Matrix<double, 9, 9>::Zero();  // row by row
  double compliance = 0.0;                                                           // m/N, of hand and arm
  double anisotropy = 1.0;  // of the hand as fitted: softest over stiffest direction
  double scatter = 0.0;     // m/N, per component, of one ramp's response
  double cost = 0.0;        // of the joints as they are; about `freedoms` where that explains it
  int freedoms = 0;
  double next_cost = 0.0;  // of the best explanation with joints or axes exchanged
};

// Wrong use: fewer than two ramps along an axis of any pose, no pose, numbers that are not finite.
Expected<ForceCheck> check_forces(std::span<const ForcePose> poses, const ForceCheckSettings& settings = {});

// --- size

struct WeightGain {
  double gain = 1.0;  // felt over commanded
  double deviation = 0.0;
  double friction = 0.0;  // N, of the arm: half of what lies between rising and sinking
};

// A weight that lies on a support, or hangs at the resting stylus, begins to rise when the commanded force upwards
// passes (weight + friction) / gain, and to sink again below (weight - friction) / gain: `rising` and `sinking` are
// those forces, a pair for each time, N. Deviation by their scatter. Refused: fewer than three, forces that are not
// positive, a gain that is not shown to lie within agreed_ratio of 1.
Expected<WeightGain> gain_of_weight(double weight_n, std::span<const double> rising,
                                    std::span<const double> sinking, const ForceCheckSettings& settings = {});

}  // namespace palpate::calibration
