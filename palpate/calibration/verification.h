// How good a calibrated rig is today, told from fresh observations and without any truth; and, where it is not
// what its calibration promised, which part of it has changed since.
//
// Everything observed is predicted from the rig. The whitened differences e hold the devices' noise, the hand's
// misses and the calibration's own errors c, whose covariance C the rig states:
//   e = A c + B(h) + n,   Cov(e) = S = I + A C A'
// with h what a change did: a camera turned on its marker, an arm's base that was pushed, a refocused lens. For
// each change that is known of, h minimises e' S^-1 e (levenberg_marquardt.h); its fall D from h = 0 is
// chi-square with as many degrees as h has numbers where nothing has changed. A change is told where D is above
// the quantile that all of them together exceed with the chance `false_alarm` (Bonferroni); of several the one
// with the largest evidence, D - log det(I + P B' S^-1 B), P the prior covariance of a change (Laplace). Another
// one is looked for beside it in the same way. Where the residuals are larger than stated, D is divided by their
// mean square: doubt is given to the noise.
//
// Frames: World (tracker), CameraMarker, TipMarker, Pointer. SI, rad, px. Pure functions, deterministic, any
// thread. Refused: a rig without arm or camera, observations that are not finite, none at all.
// Sources: Koch (1999), "Parameter estimation and hypothesis testing in linear models", chapter 4; MacKay (2003),
// "Information theory, inference and learning algorithms", chapter 28.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/calibration/stream_delay.h"
#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration {

// The stylus held still: encoder readings and its marker at one moment.
struct HeldStylus {
  device::JointVector joints = device::JointVector::filled(3, 0.0);  // psi, rad, uncorrected
  Pose<World, TipMarker> X_world_marker;
  Matrix6 covariance = Matrix6::Zero();  // of the marker, as device::TrackerSample has it
  Matrix3 systematic = Matrix3::Zero();  // m^2
};

// The pointer's tip on a place that the rig knows: corner `index` (0 to 3) of a surface, or landmark `index`.
struct TouchedPlace {
  std::string what;  // a surface's name, or "landmark"
  int index = 0;
  Pose<World, Pointer> X_world_pointer;
  Matrix3 covariance = Matrix3::Zero();  // m^2, of the tip, by the tracker; what the hand misses is not in it
};

struct SeenDot {
  std::size_t landmark = 0;
  device::Pixel centre = device::Pixel::Zero();          // in the camera's image, distorted
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // px^2
};

// One picture of the landmarks.
struct HeadFrame {
  Pose<World, CameraMarker>
      X_world_marker;  // by the tracker, at the picture's moment as the rig's delay has it
  Matrix6 covariance = Matrix6::Zero();
  Vector6 rate = Vector6::Zero();  // how it moves: rad/s (World, left), m/s
  std::vector<SeenDot> dots;
  double time_s = 0.0;  // of the picture, host time; for who compares with what was true then
};

struct RigObservations {
  std::optional<device::JointVector> rest;  // readings in the rest position, rad
  std::vector<HeldStylus> held;
  std::vector<TouchedPlace> touched;
  std::vector<HeadFrame> frames;
  std::optional<double> tracker_delay_s;  // after the arm, as measured now
  double tracker_delay_std_s = 0.0;
};

// In the order of their names. What moves with what: see change_words().
enum class Change {
  camera,         // on its marker: hand-eye
  lens,           // refocused: focal length, principal point
  base,           // of the arm
  encoder_zero,   // of the arm
  stylus_marker,  // bent, or moved on the stylus
  pointer,        // bent
  table,          // with wall and landmarks
  tracker,        // everything else stands where it stood
  camera_delay,
  tracker_delay,
};
inline constexpr int kChanges = 10;

std::string_view name_of(Change change);  // "stylus marker"
std::optional<Change> change_of(std::string_view name);

struct FoundChange {
  Change change = Change::camera;
  // By so much: of a camera, a base, a table or a tracker rotation 3 (rad) and shift 3 (m), axes of the frame it is
  // calibrated in; of a lens the focal length's share and the principal point's shift (px); of the encoders'
  // zero the joints' angles (rad); of a tip its shift in its marker (m); of a delay s.
  Eigen::VectorXd amount;
  Eigen::MatrixXd covariance;
  double fall = 0.0;         // D
  double probability = 0.0;  // of so large a D where nothing has changed
  double evidence = 0.0;
};

// A figure of today. Lengths in m, pixels, s; rms of vectors' lengths. Intervals hold with 95 %.
struct RigFigure {
  std::string name, unit;  // "arm", "mm"; SI values are told in this unit
  double scale = 1.0;      // from SI to it
  double seen = 0.0;       // rms of the differences observed now
  double seen_high = 0.0;  // what these stay below as long as the rig is what it promised; 0: not predicted
  // The rig's own error now, free of the devices' noise as far as this can be told, and what it stays within.
  double error = 0.0, low = 0.0, high = 0.0;
  double promised = 0.0, promised_high = 0.0;  // that error by the calibration's covariances: rms, and 95 %
};

struct VerificationOptions {
  double false_alarm = 0.01;  // of all tests together
  rig::TouchNoise touch;      // of the hand; without freedoms: as the rig's surfaces tell
  double pixel_sd = 0.03;     // px, beyond what a sighting states
  // The tracker's systematic error where the head's marker is now, beside what the hand-eye calibration has taken
  // in: it differs by the distance between the two.
  double head_turn_sd = 2e-4, head_shift_sd = 5e-5;  // rad, m
  double field_reach = kSystematicReach;             // a systematic error of the tracker turns markers, too
  // s: of each delay beside what rig and observations state, where they share an error that neither shows.
  double delay_sd = 3e-5;
  // The same where stamps come from a machine that does other things as well: its shortest latency, which clocks are
  // compared by, is another one from visit to visit.
  static constexpr double kLiveDelaySd = 3e-4;
  int most_changes = 3;
};

struct Verification {
  std::vector<FoundChange> changes;  // in the order they were found; none: the rig holds
  bool explained = true;             // false: with these changes the observations still do not fit
  std::vector<FoundChange> tried;    // all that could be told by these observations, alone
  double misfit = 1.0;               // mean square of the whitened residuals, in the end; about 1
  double freedoms = 0.0;
  std::vector<RigFigure> figures;
  std::string
      farthest;  // what of the observations is off most, with these changes: "the touch of landmark 3"
  double farthest_sds = 0.0;  // ... by so many of its standard deviations

  bool holds() const { return changes.empty() && explained; }
};

Expected<Verification> verify_rig(const rig::Rig& rig, const RigObservations& observed,
                                  const VerificationOptions& options = {});

// What has changed, by how much, and the command that mends it: for a person.
std::string change_words(const FoundChange& change);

}  // namespace palpate::calibration
