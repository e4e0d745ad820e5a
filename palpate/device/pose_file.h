// Files of rigid poses as people bring them, read into metres and unit quaternions.
//
// Recognised by themselves:
//  - CSV with a header naming x, y, z as `x_mm` or `x_m` and qw, qx, qy, qz (`marker_x_mm`, `marker_qw` ...
//  too);
//  - CSV with a header m00 ... m23 (a row-major 3x4 or 4x4 matrix), translation in mm;
//  - CSV without a header: 8 columns t, x, y, z, qx, qy, qz, qw in s and m, sorted by time here, repeated
//  times kept
//    once; 12 or 16 columns: row-major matrices in mm;
//  - PLUS / 3D Slicer sequences (.igs.mha): mm; frames whose status is not OK are left out;
//  - a folder of text files (.txt, .csv, .dat), one row-major 4x4 matrix in mm each, in name order.
// Rows in which no cell of the pose is a number are left out: the body was hidden.
// The pose maps coordinates of the tracked body to the frame it is reported in. Errors: wrong use, with file
// and line.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/core/expected.h"
#include "palpate/math/pose.h"

namespace palpate::device {

struct StampedPose {
  double time_s = 0.0;  // row number where the file has no time
  Quaternion rotation = Quaternion::Identity();
  Vector3 translation = Vector3::Zero();  // m
  int segment = -1;                       // index into PoseFile::segments; -1 = in none

  template <typename A, typename B>
  Pose<A, B> as() const {
    return {rotation, translation};
  }
};

// Each pose turned round: that of the frame it is reported in, in the body. Times and segments as they were.
std::vector<StampedPose> inverted(std::vector<StampedPose> poses);

// What a quaternion is whose four numbers were told as w x y z and are x y z w, or (false) the other way round. Such a
// mistake is the inverse turn between two constant ones.
Quaternion in_other_order(const Quaternion& told, bool told_scalar_first);

struct PoseFile {
  std::string source, hash;  // file name; content_hash of what was read
  bool has_time = false;
  std::string unread_time;  // a column that looks like the time's, where there is no time_s
  std::vector<StampedPose> poses;
  std::vector<std::string> segments;  // labels, in order of appearance
  std::size_t left_out = 0;           // rows and frames in which the body was hidden
  CsvTable table;  // all columns as read, row i belongs to pose i; empty for the other forms
};

struct PoseFileOptions {
  std::string transform;  // "StylusToReference": which transform of a sequence; may be a chain of those in it
  std::string segment_column;  // 0 or empty = in no segment
};

Expected<PoseFile> read_poses(const std::filesystem::path& path, const PoseFileOptions& options = {});
// A table or sequence whose content is read already; `source` names it in messages.
Expected<PoseFile> parse_poses(std::string_view content, std::string source,
                               const PoseFileOptions& options = {});
// One file of a folder: a row-major 4x4 matrix in mm.
Expected<StampedPose> parse_matrix(std::string_view content, const std::string& source);

// The header's columns of a pose, "marker_" or "" in front; none where the header has no such pose.
struct PoseColumns {
  std::size_t x, y, z, qw, qx, qy, qz;
  double metres_per_unit;
};
std::optional<PoseColumns> find_pose_columns(const CsvTable& table, const std::string& prefix);
// Row's pose; a quaternion whose length is not 1 within 2 % is wrong use.
Expected<StampedPose> pose_from_row(const CsvTable& table, std::size_t row, const PoseColumns& columns);
// From a row-major matrix of 12 or 16 numbers, the first three rows of a 4x4 one or all of it. A left part that is no
// rotation within 2e-3 is wrong use, and a fourth row other than 0 0 0 1.
Expected<StampedPose> pose_from_matrix(std::span<const double> m, double metres_per_unit,
                                       const std::string& where);

}  // namespace palpate::device
