#include "palpate/calibration/session/guided_poses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "palpate/calibration/gimbal.h"
#include "palpate/calibration/session/arm_observations.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration::session {
namespace {

constexpr int kPerJoint = 5;                    // of the grid over the workspace
constexpr std::size_t kToleratesOutliers = 15;  // samples; with fewer, a free fit calls good ones outliers
constexpr std::size_t kFewestOfACurve = 6;      // samples for fourteen unknowns
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

std::vector<Eigen::VectorXd> workspace_of(const ReachablePoses& reach) {
  return joint_grid({reach.joint_range.begin(), reach.joint_range.end()}, kPerJoint);
}

double coverage_of(const std::vector<TrackedPose>& poses, const ReachablePoses& reach) {
  std::set<int> cells;
  for (const auto& pose : poses) {
    int cell = 0;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const auto& [low, high] = reach.joint_range[static_cast<std::size_t>(j)];
      const double share = (pose.joints[j] - low) / (high - low);
      cell = 3 * cell + std::clamp(static_cast<int>(std::floor(3.0 * share)), 0, 2);
    }
    cells.insert(cell);
  }
  return static_cast<double>(cells.size()) / 27.0;
}

// In words, where a place lies within the box of all places. World: x to the right, y up, z towards a person
// who faces the tracker.
std::string region_name(const Vector3& place, const Vector3& low, const Vector3& high) {
  constexpr std::array<std::array<const char*, 2>, 3> kWords{
      {{"left", "right"}, {"low", "high"}, {"far", "near"}}};
  std::string name;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double share = (place[k] - low[k]) / std::max(1e-9, high[k] - low[k]);
    if (share > 1.0 / 3.0 && share < 2.0 / 3.0) continue;
    name +=
        (name.empty() ? "" : ", ") + std::string(kWords[static_cast<std::size_t>(k)][share > 0.5 ? 1 : 0]);
  }
  return name.empty() ? "middle" : name;
}

// By how much the samples scatter more than the tracker believes; at least 1.
double noise_ratio(const Estimate<ArmSolution>& estimate,
                   const std::vector<device::ArmObservation>& samples) {
  constexpr double kEnough = 15.0;  // degrees of freedom, for a ratio good to a fifth
  double chi2 = 0.0;
  int rows = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].covariance || (!estimate.inlier.empty() && !estimate.inlier[i])) continue;
    chi2 +=
        estimate.residuals[i].dot(Vector3(solve_symmetric(*samples[i].covariance, estimate.residuals[i])));
    rows += 3;
  }
  const double freedom = rows - static_cast<double>(estimate.value.parameters.size());
  return freedom < kEnough ? 1.0 : std::max(1.0, std::sqrt(chi2 / freedom));
}

}  // namespace

std::string guidance_text(const GuidanceState& state) {
  const std::string visited = fmt::format("{:.0f} % of the range visited", 100.0 * state.coverage);
  if (!std::isfinite(state.predicted_error)) return visited;
  return fmt::format("predicted error {:.2f} mm, largest {:.2f} mm ({}), {}",
                     mm_from_metres(state.predicted_error), mm_from_metres(state.worst_error),
                     state.worst_region, visited);
}

GuidedPoses::GuidedPoses(GuidanceOptions options)
    : options_(std::move(options)),
      workspace_(workspace_of(options_.reach)),
      candidates_(options_.seed, "guidance/candidates") {
  options_.design.free = options_.arm.free;
}

ArmRecordingOptions GuidedPoses::recording(int points) {
  points_ = points;
  ArmRecordingOptions recording;
  recording.points = points;
  recording.next = [this](const std::vector<TrackedPose>& poses) { return next(poses); };
  recording.kept = [this](const std::vector<TrackedPose>& poses) { kept(poses); };
  return recording;
}

std::optional<device::PoseTarget> GuidedPoses::next(const std::vector<TrackedPose>& poses) {
  if (planned_.empty()) plan(poses);
  if (planned_.empty()) return std::nullopt;
  const device::PoseTarget target = planned_.front();
  planned_.pop_front();
  return target;
}

void GuidedPoses::plan(const std::vector<TrackedPose>& poses) {
  if (!arm_) return;
  const auto samples = arm_observations(poses, options_.tip);
  std::optional<Quaternion> mount;
  if (const auto gimbal = calibrate_gimbal(samples, {.value = *arm_})) mount = gimbal->value.R_tip_marker;
  const auto drawn =
      candidate_poses(*arm_, options_.reach, options_.candidates, candidates_, mount,
                      PoseNoise{poses.back().marker.covariance, poses.back().marker.systematic});
  if (drawn.empty()) return;
  PoseDesign design(*arm_, workspace_, drawn, options_.design);
  for (const auto& sample : samples) design.take(sample);
  const int count = std::clamp(points_ - static_cast<int>(poses.size()), 1, options_.every);
  for (const std::size_t index : design.plan(count, 1))
    planned_.push_back(
        {predict_tip(*arm_, drawn[index].joints), drawn[index].marker->rotation, arm_->tip_in_marker});
}

void GuidedPoses::kept(const std::vector<TrackedPose>& poses) {
  const auto samples = arm_observations(poses, options_.tip);
  const std::size_t n = samples.size();
  const bool due = n >= static_cast<std::size_t>(options_.spread) &&
                   (!arm_ || n >= solved_at_ + static_cast<std::size_t>(options_.every));
  if (due) {
    ArmOptions how = options_.arm;
    how.allow_field = false;  // for the covariance, which is not needed here
    how.robust = how.robust && n >= kToleratesOutliers;
    // Refused where the poses do not determine the arm yet: one more that the person likes.
    if (const auto estimate = calibrate_arm(samples, options_.model, how)) {
      arm_ = estimate->value;
      noise_ratio_ = noise_ratio(*estimate, samples);
      solved_at_ = n;
      planned_.clear();
    }
  }
  GuidanceState state;
  state.poses = static_cast<int>(n);
  state.coverage = coverage_of(poses, options_.reach);
  state.predicted_error = state.worst_error = kNotANumber;
  if (arm_) {
    PoseDesign design(*arm_, workspace_, {}, options_.design);
    for (auto sample : samples) {
      if (sample.covariance) *sample.covariance *= noise_ratio_ * noise_ratio_;
      design.take(sample);
    }
    state.predicted_error = design.predicted_error();
    state.worst_error = 0.0;
    Vector3 low = Vector3::Constant(1e9), high = -low;
    for (const auto& psi : workspace_) {
      const Vector3 place = predict_tip(*arm_, psi).m;
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
      const double error = design.predicted_error_at(psi);
      if (error <= state.worst_error) continue;
      state.worst_error = error;
      state.worst_place = place;
    }
    state.worst_region = region_name(state.worst_place, low, high);
  }
  history_.push_back(state);
  if (options_.report) options_.report(state);
}

std::vector<double> predicted_error_curve(const ArmSolution& arm,
                                          const std::vector<device::ArmObservation>& samples,
                                          const ReachablePoses& reach, const DesignOptions& options) {
  std::vector<double> curve;
  PoseDesign design(arm, workspace_of(reach), {}, options);
  for (const auto& sample : samples) {
    design.take(sample);
    curve.push_back(curve.size() + 1 < kFewestOfACurve ? kNotANumber : design.predicted_error());
  }
  return curve;
}

}  // namespace palpate::calibration::session
