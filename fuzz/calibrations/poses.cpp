// Tables of poses (CSV in all its forms) into the pivot calibration.
#include "fuzz/check.h"
#include "palpate/calibration/pivot.h"
#include "palpate/device/pose_file.h"

namespace palpate::fuzz {
namespace {

void pivot_of(const device::PoseFile& file, bool with_segments, Refusals& refusals) {
  std::vector<calibration::PivotPose> poses;
  for (const auto& pose : file.poses) {
    hold(std::abs(pose.rotation.norm() - 1.0) < 1e-6 && pose.translation.allFinite(), "poses read are rigid");
    hold_finite(pose.time_s, "times read are finite");
    if (poses.size() < kMostRows)
      poses.push_back({pose.rotation, pose.translation, with_segments ? pose.segment : 0, std::nullopt});
  }
  for (const auto method : {calibration::PivotMethod::algebraic, calibration::PivotMethod::sphere,
                            calibration::PivotMethod::robust}) {
    const auto pivot = calibration::calibrate_pivot(poses, {.method = method});
    if (answered(pivot, refusals)) hold_finite(pivot->value.tip, "a tip is finite");
  }
  // One pose for each pivot leaves nothing over to judge the errors by: then, and only then, no variance is
  // known.
  const auto pivots =
      calibration::calibrate_pivot(poses, {.given_tip = Vector3(0.007, -0.018, -0.118)});  // of header_mm.csv
  const bool judged = !pivots || pivots->residuals.size() > pivots->value.segments.size();
  if (judged ? answered(pivots, refusals) : answered<Estimate<calibration::PivotSolution>>(pivots, refusals))
    for (const auto& segment : pivots->value.segments) hold_finite(segment.pivot, "a pivot is finite");
  // The tip moved by what the marker did: any motion of the arm does here.
  for (auto& pose : poses) pose.motion = pose.rotation * Vector3(0.001, 0.0, 0.002);
  answered(calibration::calibrate_pivot(poses, {.with_motion = true}), refusals);
}

}  // namespace

Refusals poses(std::string_view file) {
  Refusals refusals;
  const auto read = device::parse_poses(file, "poses.csv");
  if (answered(read, refusals)) pivot_of(*read, false, refusals);
  if (file.find("segment") == std::string_view::npos) return refusals;
  const auto in_segments = device::parse_poses(file, "poses.csv", {.segment_column = "segment"});
  if (answered(in_segments, refusals)) pivot_of(*in_segments, true, refusals);
  return refusals;
}

}  // namespace palpate::fuzz
