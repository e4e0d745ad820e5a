// The rig: everything known about one real (or simulated) set of devices, as it stands in the rig file.
//
// A rig restores the whole system after a restart: nothing is calibrated twice. Each part carries its
// provenance and is absent until it has been calibrated. SI and radians inside; the file (TOML) has units in
// its key names. Values; copied freely. The truth of a simulated laboratory is never in here.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/arm_model.h"
#include "palpate/device/camera_model.h"
#include "palpate/device/charuco_board.h"
#include "palpate/device/light.h"
#include "palpate/math/pose.h"
#include "palpate/rig/force_calibration.h"
#include "palpate/rig/headset_calibration.h"
#include "palpate/rig/provenance.h"
#include "palpate/rig/verification_record.h"
#include "palpate/time/instant.h"

namespace palpate::rig {

struct PivotCalibration {                   // of a rigid body with a tip: TipMarker or Pointer
  Vector3 tip_in_marker = Vector3::Zero();  // m
  Matrix3 covariance = Matrix3::Zero();     // m^2
  Provenance from;
};

struct ArmCalibration {
  device::ArmModel model;  // its name, and its kinematics as calibrated
  device::JointCorrection correction;
  Pose<World, ArmBase> X_world_base;
  Vector3 tip_in_marker = Vector3::Zero();  // as the joint solve sees it
  // Turn of the marker on the stylus; fitted beside the arm, from gimbal angles and marker poses.
  Quaternion R_tip_marker = Quaternion::Identity();
  Vector3 gimbal_gain = Vector3::Ones();
  Vector3 gimbal_offset = Vector3::Zero();
  // In the order of covariance_order(): gains and offsets of all joints, base rotation 3 (rad), base
  // translation 3 (m), tip 3 (m), of a chain its tool 3 (m), of a Cartesian arm its correction 24 (m); 15 x 15
  // of a PHANToM, zero where fixed, empty where unknown.
  Eigen::MatrixXd covariance;
  // Encoder readings with the arm in its rest (reset) position at calibration: a later start whose rest
  // readings differ has lost its encoder zero.
  device::JointVector rest_readings = device::JointVector::filled(3, 0.0);
  bool rest_known = true;      // else nobody has read them, and they are zero here
  double held_out_mean = 0.0;  // m
  Provenance from;
};

// Where this calibration puts the tip with all readings zero and with each in turn at 0.5 rad (a place's: 0.1 m): two
// rigs that say the same of their arm agree in all of them.
std::vector<Point<World>> tips_of_arm(const ArmCalibration& arm);

// The rows of ArmCalibration::covariance, as the calibration names what it estimates: "gain_1", "tip_x".
std::vector<std::string> covariance_order(const device::ArmModel& model);

struct CameraCalibration {
  device::CameraModel model;
  Eigen::MatrixXd covariance;  // 9x9: fx fy cx cy (px) k1 k2 p1 p2 k3; empty where unknown
  Provenance from;
  device::Encoding encoding = device::Encoding::root;  // absent in the file: root, as the simulated camera's
};

struct HandEyeCalibration {  // camera in its marker
  Pose<CameraMarker, CameraOptical> X_marker_camera;
  Matrix6 covariance = Matrix6::Zero();  // rotation (rad) then translation (m)
  Provenance from;
};

// Constant delays left between the devices' host stamps: device time = stamp - delay, in the arm's time.
// A deviation of kUnknownDelay says that nobody has measured this one.
inline constexpr double kUnknownDelay = 1.0;  // s
// Between stamps of one machine no delay is as long: the clocks that stamped have different origins.
inline constexpr double kLongestDelay = 3.0;  // s
struct DelayCalibration {
  double tracker_after_arm_s = 0.0;     // a tracker stamp t shows the world at t - this
  double camera_after_tracker_s = 0.0;  // a camera stamp t equals the tracker stamp t - this
  double tracker_std_s = kUnknownDelay, camera_std_s = kUnknownDelay;
  bool tracker_known() const { return tracker_std_s < kUnknownDelay; }
  bool camera_known() const { return camera_std_s < kUnknownDelay; }
  Provenance from;
};

// By how much a hand misses what it touches per axis, and how many independent residuals say so (0: none do).
struct TouchNoise {
  double sd = 0.0;  // m
  double freedoms = 0.0;
};

// A real rectangle: pose of its corner frame (x to corner 2, y to corner 4, z = x cross y) and its sides.
struct SurfaceCalibration {
  std::string name;  // "table", "wall"
  Pose<World, Rectangle> X_world_rectangle;
  double width = 0.0, height = 0.0;  // m, along x and y
  // 8 x 8: rotation 3 (rad, World axes), corner 1 (3, m), width, height (m); empty where unknown.
  Eigen::MatrixXd covariance;
  Provenance from;
  TouchNoise touch{};                // as its own touches tell
  Point<World> corner(int i) const;  // 0..3, in touching order
};

struct Landmark {  // a round dot of known size at a calibrated place
  Point<World> place;
  Matrix3 covariance = Matrix3::Zero();
  Vector3 normal = Vector3::UnitY();
  double diameter = 0.008;
};

// A real body of known shape at a registered place (a phantom head, a vise): it hides virtual things.
struct RealObject {
  std::string name;
  std::string mesh;  // file, as written; relative to the rig file's folder
  double metres_per_unit = 0.001;
  Quaternion rotation = Quaternion::Identity();  // mesh frame in World
  Vector3 position = Vector3::Zero();            // m
};

// A printed board that stays where it lies. Where a rig has one the camera's place is read off it in every
// picture, and neither tracker nor hand-eye are asked for.
struct BoardPlacement {
  device::CharucoBoard board;
  Pose<World, Board> X_world_board;
};

// The arm of a rig whose hand is a mouse: it is computed, and no picture shows it.
inline constexpr const char* kMouseArm = "mouse";

struct Rig {
  std::string name = "rig";
  device::ArmModel nominal_arm;  // as its maker describes it; its name counts for a chain
  std::vector<Vector3> tip_marker_leds, camera_marker_leds, pointer_leds;  // m, marker frames
  std::optional<PivotCalibration> tip_pivot, pointer_pivot;
  std::optional<ArmCalibration> arm;
  std::optional<ForceCalibration> forces;   // without it a real arm is given none
  std::optional<CameraCalibration> camera;  // of two: the left eye's
  std::optional<HandEyeCalibration> hand_eye;
  // A second camera on the same marker, which takes its images at the same moments.
  std::optional<CameraCalibration> right_camera;
  std::optional<HandEyeCalibration> right_hand_eye;
  std::optional<HeadsetCalibration> headset;  // without it the camera is taken to sit between the eyes
  std::optional<BoardPlacement> board;
  std::optional<DelayCalibration> delays;
  std::vector<SurfaceCalibration> surfaces;
  std::vector<Landmark> landmarks;
  // What registers pictures with World, where one solve found it: lens 9 (as camera->covariance), hand-eye 6,
  // then 3 of each landmark. Their errors belong together and cancel in part: taken apart they count too
  // much. Empty where unknown; use registration_covariance().
  Eigen::MatrixXd registration_covariance;
  // The same with the right camera's lens and hand-eye (palpate/vision/second_camera.h).
  Eigen::MatrixXd right_registration_covariance;
  Provenance landmarks_from;
  std::optional<device::RoomLight> light;
  std::vector<RealObject> objects;
  std::vector<VerificationRecord> verifications;  // oldest first; the newest kVerificationsKept are written
  std::filesystem::path folder;                   // of the file it was read from; not written

  const SurfaceCalibration* surface(std::string_view surface_name) const;
};

// That covariance; where the rig has none, or a part of it was calibrated anew since (its own covariance is
// then another), the parts' own beside each other. What is not calibrated has none.
Eigen::MatrixXd registration_covariance(const Rig& rig);

// Both cameras of a stereo rig are calibrated.
bool has_two_eyes(const Rig& rig);
// The right camera in the left one; needs has_two_eyes.
struct RightCamera;
Pose<CameraOptical, RightCamera> right_in_left(const Rig& rig);
// The right camera's pose where the left one's is known, as refinement has found it: the two do not move
// against each other.
Pose<World, CameraOptical> right_eye_pose(const Rig& rig, const Pose<World, CameraOptical>& X_world_left);

// The rig as it would be with the right camera alone, in the left one's place; needs has_two_eyes.
Rig right_eye_rig(const Rig& rig);

// By how much the arm's rest readings differ from those at calibration, rad (of a Cartesian arm m). The encoders count from wherever
// the arm stood when it was switched on: a change means that the zero, and with it the calibration, has
// moved.
device::JointVector rest_change(const ArmCalibration& arm, const device::JointVector& rest_readings);
// A hand puts an arm back into its rest position to a few tenths of a degree.
inline constexpr double kRestTolerance = 0.0087;       // rad, half a degree
inline constexpr double kRestPlaceTolerance = 0.0009;  // m, of a Cartesian arm: half a degree at a decimetre
inline double rest_tolerance(const device::ArmModel& model) {
  return model.kind == device::ArmModel::Kind::cartesian ? kRestPlaceTolerance : kRestTolerance;
}
// Gains of an arm calibrated anew differ by less: half a degree at a radian.
inline constexpr double kGainTolerance = 0.0087;
// A length of an arm's model may change so much when it is calibrated anew: a hundredth of a link.
inline constexpr double kLengthTolerance = 0.003;  // m

// The part of a check of forces that says what it holds for: this arm, as the rig's calibration has it now. Nothing is
// measured in it. Needs rig.arm.
ForceCalibration force_calibration_of(const Rig& rig, const std::string& identity);

// Why the check of the forces does not hold any more for this arm (as its driver names it; empty: whichever it is),
// in words that go after "since they were checked"; empty: it holds. Needs rig.forces.
std::string void_reason(const Rig& rig, const std::string& identity);

// `length`, m, as it is once a rig's file has been read, where it stands in mm to a whole micrometre. A constant
// in metres can differ from that by its last bit, and 209.55 would be written as 209.54999999999998.
double as_filed(double length);

// A rig for a desk and a webcam: the board lies on the table, near the edge that faces the camera; where the
// board lies, the table is, and at its far end stands a wall that only the picture shows. World as the
// reference laboratory has it, so that the arm which the mouse moves reaches the table's near half. `width`
// and `length` of the table, m. What it lacks is the camera's lens.
Rig desk_rig(const device::CharucoBoard& board, double width = 0.75, double length = 1.0);

// The parts a rig still lacks, in the order in which they are calibrated, each with the command that brings
// it.
struct MissingPart {
  std::string part, remedy;
};
std::vector<MissingPart> missing_parts(const Rig& rig);

// The date of what was measured in a simulated laboratory: the epoch, so that the same seed gives the same file.
constexpr const char* kSimulatedDate = "1970-01-01T00:00:00Z";

// Now, as Provenance writes it.
std::string utc_now();

// Reads a rig file. Unknown keys, wrong types and impossible values are wrong use, named with file and line.
Expected<Rig> read_rig(const std::filesystem::path& path);
Expected<Rig> parse_rig(std::string_view content, const std::string& source);
// The file's text; read back it gives the same rig, to 1e-12 of each number.
std::string rig_text(const Rig& rig);
// Refuses a rig that could not be read again (a covariance of the wrong size, a quaternion that is none).
Expected<void> write_rig(const std::filesystem::path& path, const Rig& rig);

}  // namespace palpate::rig
