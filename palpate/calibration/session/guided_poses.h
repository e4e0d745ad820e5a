// Guided collection of an arm's poses: after a few that the person chooses, the stylus is shown where it
// helps most, and after each pose it is known how good the calibration would be by now.
//
// Every few poses the arm is calibrated anew with what there is, candidates are drawn, and the next ones are
// planned (next_pose.h). World frame, SI. Deterministic for seed and recordings. One thread.
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "palpate/calibration/next_pose.h"
#include "palpate/calibration/pose_candidates.h"
#include "palpate/calibration/session/procedures.h"

namespace palpate::calibration::session {

// What is known after a pose. Errors are predicted, m rms; not numbers before the first solve.
struct GuidanceState {
  int poses = 0;
  double coverage = 0.0;  // share of the 27 parts of the joints' range (thirds of each) that hold a pose
  double predicted_error = 0.0;           // over the workspace
  double worst_error = 0.0;               // at the worst place of it
  Vector3 worst_place = Vector3::Zero();  // World
  std::string worst_region;               // for a person who faces the tracker: "left, low, far"
};

// "predicted error 0.08 mm, largest 0.13 mm (left, low, far), 63 % of the range visited"
std::string guidance_text(const GuidanceState& state);

struct GuidanceOptions {
  int spread = 8;        // poses of the person's own choice before the first solve
  int every = 4;         // poses between solves
  int candidates = 800;  // drawn anew for each plan
  device::ArmModel model;
  ArmOptions arm;  // how the samples will be calibrated; what it frees is what the poses are chosen for
  Vector3 tip = Vector3::Zero();  // in the marker, as far as it is known: for the tip's covariance
  ReachablePoses reach;
  DesignOptions design;  // its `free` is taken from `arm`
  std::uint64_t seed = 1;
  std::function<void(const GuidanceState&)> report;  // after each pose
};

class GuidedPoses {
 public:
  explicit GuidedPoses(GuidanceOptions options);
  // `options` with this object asked for each pose and told of each; it must outlive the recording.
  ArmRecordingOptions recording(int points);
  const std::vector<GuidanceState>& history() const { return history_; }

 private:
  std::optional<device::PoseTarget> next(const std::vector<TrackedPose>& poses);
  void kept(const std::vector<TrackedPose>& poses);
  void plan(const std::vector<TrackedPose>& poses);

  GuidanceOptions options_;
  int points_ = 0;
  std::vector<Eigen::VectorXd> workspace_;
  Random candidates_;
  std::optional<ArmSolution> arm_;
  double noise_ratio_ = 1.0;
  std::size_t solved_at_ = 0;
  std::deque<device::PoseTarget> planned_;
  std::vector<GuidanceState> history_;
};

// Predicted error (m rms over the joints' range) after each of `samples`, in their order, for an arm that is
// about `arm`; not a number while there are fewer samples than a solve needs.
std::vector<double> predicted_error_curve(const ArmSolution& arm,
                                          const std::vector<device::ArmObservation>& samples,
                                          const ReachablePoses& reach, const DesignOptions& design);

}  // namespace palpate::calibration::session
