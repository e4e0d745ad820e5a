// What was recorded to calibrate an arm: encoder readings with the tip's measured place or its marker's pose.
//
// CSV, recognised by its header: `joint_1_deg` ... (or `_rad`; of a Cartesian arm `arm_x_mm`, `arm_y_mm`,
// `arm_z_mm`, or `_m`, the place it states), optional `gimbal_1_deg` ..., optional
// `time_s`, then `x_mm,y_mm,z_mm` (measured tip) and/or `marker_x_mm,...,marker_qw,...` (marker pose),
// optional `cov_xx_mm2, cov_xy_mm2, cov_xz_mm2, cov_yy_mm2, cov_yz_mm2, cov_zz_mm2` of the measured tip,
// optional `systematic_mm`: the 3-D rms of the tracker's systematic error in it. Also
// the form with `x_t,y_t,z_t`, `x_dif,y_dif,z_dif`, `joint_1` ...: mm and degrees, measured = target + dif.
// Rows in which the tracker saw nothing (no number for tip or marker) are left out. SI and radians here. Frames: World is the tracker's. Errors: wrong use, with file and line.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/pose.h"

namespace palpate::device {

struct ArmObservation {
  Eigen::VectorXd joints;         // psi, encoder readings as angles, rad, uncorrected; of a Cartesian arm m
  std::optional<Vector3> gimbal;  // rad, uncorrected
  std::optional<double> time_s;
  std::optional<Pose<World, TipMarker>> marker;
  std::optional<Point<World>> tip;     // measured tip
  std::optional<Point<World>> target;  // where the arm's own controller believed the tip to be
  std::optional<Matrix3> covariance;   // of the measured tip, m^2, the tracker's systematic error included
  std::optional<double> systematic;    // m, 3-D rms of that part, the same for places near each other
  int line = 0;                        // in its file; 0: of none
};

struct ArmSampleFile {
  std::string source, hash;
  bool places = false;  // a Cartesian arm's
  std::vector<ArmObservation> observations;
  std::size_t left_out = 0;  // rows in which the tracker saw nothing
};

Expected<ArmSampleFile> read_arm_samples(const std::filesystem::path& path);
Expected<ArmSampleFile> parse_arm_samples(std::string_view content, std::string source);

}  // namespace palpate::device
