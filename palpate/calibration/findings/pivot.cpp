#include "palpate/calibration/findings/pivot.h"

#include <algorithm>
#include <limits>

#include "palpate/calibration/pivot_rests.h"
#include "palpate/device/pose_file.h"
#include "palpate/device/repeats.h"
#include "palpate/math/linear_algebra.h"
#include "palpate/rig/doubtful_values.h"

namespace palpate::calibration::findings {
namespace {

// A held tip wanders by 1-2 mm; beyond this it did not rest.
constexpr double kRestlessTip = 0.004;  // m, rms

constexpr double kShiftThatMatters = 0.0001;  // m

constexpr double kPoorlyKnown = 0.002;  // m, standard deviation: twenty times what a tip has to be known to

// A pose is the same if marker, tip and segment are; when it was read does not matter.
device::Reading reading_of_pose(const PivotPose& pose) {
  return device::Reading()
      .add(pose.rotation.coeffs())
      .add(pose.translation)
      .add(pose.segment)
      .add_if(pose.motion);
}

// When each segment began and ended; nothing where the poses have no times.
void add_times(const std::vector<PivotPose>& poses, Json& segments) {
  for (const auto& pose : poses) {
    if (pose.segment < 0 || !pose.time_s) continue;
    Json& entry = segments[static_cast<std::size_t>(pose.segment)];
    if (!entry.contains("from_s")) entry["from_s"] = *pose.time_s;
    entry["to_s"] = *pose.time_s;
  }
}

// The segments found by themselves, and their names.
Expected<void> find_segments(PivotTask& task) {
  const auto rests = find_pivot_rests(task.poses);
  if (!rests) return tl::unexpected(rests.error());
  put_segments(*rests, task.poses);
  task.segments.clear();
  for (std::size_t s = 0; s < rests->size(); ++s) task.segments.push_back(std::to_string(s + 1));
  return {};
}

const char* name_of(PivotMethod method) {
  return method == PivotMethod::sphere ? "sphere" : method == PivotMethod::robust ? "robust" : "algebraic";
}

std::string label_of(const PivotTask& task, std::size_t segment) {
  return task.segments.empty() ? "1" : task.segments[segment];
}

struct Fit {
  std::size_t inliers = 0;
  double rms_3d = 0.0;  // m, of the inliers
};

Fit fit_of(const Estimate<PivotSolution>& estimate) {
  Fit fit;
  double square = 0.0;
  for (std::size_t i = 0; i < estimate.residuals.size(); ++i) {
    if (!estimate.inlier.empty() && !estimate.inlier[i]) continue;
    ++fit.inliers;
    square += estimate.residuals[i].squaredNorm();
  }
  fit.rms_3d = std::sqrt(square / static_cast<double>(fit.inliers));
  return fit;
}

// What is known of the tip's own motion and of errors that poses share, as far as the solution tells.
void put_motion(Json& json, const PivotTask& task, const PivotSolution& solution) {
  if (solution.bootstrap_block > 0) {
    json["bootstrap_tip_std_mm"] = json_list(solution.bootstrap_std, kMm);
    json["bootstrap_block_poses"] = solution.bootstrap_block;
    json["shared_error_mm"] = kMm * solution.field_sd;
  }
  if (solution.tip_motion > 0.0) json["tip_motion_rms_mm"] = kMm * solution.tip_motion;
  if (solution.tip_shift) json["tip_shift_by_motion_mm"] = json_list(*solution.tip_shift, kMm);
  if (solution.tip_scatter.trace() > 0.0)
    json["tip_scatter_mm"] = json_list(standard_deviations(solution.tip_scatter), kMm);
  if (task.how.with_motion) json["arm_in_world_qwxyz"] = json_quaternion(solution.R_world_arm);
  if (task.how.with_motion) json["delay_s"] = solution.delay;
}

Json segment_json(const PivotSegment& segment, const std::string& label, const Vector3& std_pivot) {
  Json entry;
  entry["label"] = label;
  entry["poses"] = segment.poses;
  entry["tip_mm"] = segment.own_tip ? json_list(*segment.own_tip, kMm) : Json();
  entry["tip_std_mm"] =
      segment.own_covariance ? json_list(standard_deviations(*segment.own_covariance), kMm) : Json();
  entry["pivot_mm"] = json_list(segment.pivot, kMm);
  entry["pivot_std_mm"] = json_list(std_pivot, kMm);
  entry["rms_mm"] = kMm * segment.own_rms;
  entry["rms_common_tip_mm"] = kMm * segment.rms;
  return entry;
}

// The direction in which the tip is known worst, where that is poorly.
std::string warning_of_poor_tip(const Matrix3& covariance) {
  if (!covariance.allFinite()) return "";
  const auto axes = symmetric_eigen(covariance);
  const double worst = std::sqrt(std::max(0.0, axes.values[2]));
  if (worst <= kPoorlyKnown) return "";
  const Vector3 along = axes.vectors.col(2);
  return fmt::format(
      "the tip is known to {:.1f} mm only along ({:.2f}, {:.2f}, {:.2f}) of its marker; swing it further, in "
      "two directions, "
      "and leave out poses in which it did not rest (--segments auto)",
      mm_from_metres(worst), along.x(), along.y(), along.z());
}

// How else the poses may have been meant, in words, if so they agree with a tip at rest; else empty. rms_3d: as they stand.
std::string other_reading(const PivotTask& task, double rms_3d) {
  constexpr double kFarBetter = 3.0;
  const auto agree = [&](const auto& change) {
    auto poses = task.poses;
    for (auto& pose : poses) change(pose);
    const auto other = calibrate_pivot(poses, task.how);
    if (!other) return false;
    const double rms = fit_of(*other).rms_3d;
    return rms < kRestlessTip && kFarBetter * rms < rms_3d;
  };
  for (const bool scalar_first : {true, false})
    if (agree([&](PivotPose& pose) { pose.rotation = device::in_other_order(pose.rotation, scalar_first); }))
      return fmt::format(
          "with each quaternion's numbers in another order they agree: read as {}, they seem to hold {}; "
          "correct the header, or the order where there is none",
          scalar_first ? "qw,qx,qy,qz" : "qx,qy,qz,qw", scalar_first ? "qx,qy,qz,qw" : "qw,qx,qy,qz");
  if (agree([](PivotPose& pose) {
        pose.rotation = pose.rotation.conjugate();
        pose.translation = -(pose.rotation * pose.translation);
      }))
    return "turned round they agree: they seem to be the tracker's in the marker (palpate convert --invert)";
  return "";
}

std::string warning_of_bad_agreement(const PivotTask& task, double rms_3d) {
  const auto other = other_reading(task, rms_3d);
  return "the poses agree badly: " +
         (other.empty()
              ? "the tip did not rest, or the file holds several pivots (--segments COLUMN, or auto)"
              : other);
}

std::vector<std::string> warnings_of(const PivotTask& task, const PivotSolution& solution,
                                     const Matrix3& covariance, double rms_3d, std::size_t repeats) {
  std::vector<std::string> warnings;
  if (repeats > 0) warnings.push_back(device::repeats_warning(repeats));
  if (solution.tip.norm() < rig::kNearestTip)
    warnings.push_back(fmt::format(
        "the tip lies only {:.4f} mm from its marker's origin: check the unit in the header (_mm or _m)",
        kMm * solution.tip.norm()));
  if (solution.tip.norm() > rig::kStylusReach)
    warnings.push_back(
        fmt::format("the tip lies {:.0f} mm from its marker's origin: are these the poses of the tracker in "
                    "the marker? Turn them "
                    "round (palpate convert --invert), and check the unit (_mm or _m)",
                    kMm * solution.tip.norm()));
  if (rms_3d > kRestlessTip) warnings.push_back(warning_of_bad_agreement(task, rms_3d));
  if (auto poor = warning_of_poor_tip(covariance); !poor.empty()) warnings.push_back(std::move(poor));
  if (solution.tip_shift && solution.tip_shift->norm() > kShiftThatMatters)
    warnings.push_back(
        fmt::format("the arm's readings show that the tip moved by {:.2f} mm rms, which puts it {:.2f} mm "
                    "off; subtract it with --with-arm",
                    kMm * solution.tip_motion, kMm * solution.tip_shift->norm()));
  return warnings;
}

Json to_json(const PivotTask& task, const Estimate<PivotSolution>& estimate, std::size_t repeats) {
  const PivotSolution& solution = estimate.value;
  const auto std_all = standard_deviations(estimate.covariance);
  const Fit fit = fit_of(estimate);
  Json json;
  json["method"] = name_of(task.how.method);
  json["tip_mm"] = json_list(solution.tip, kMm);
  json["tip_std_mm"] = json_list(std_all.head<3>(), kMm);
  if (solution.segments.size() == 1) {
    json["pivot_mm"] = json_list(solution.segments[0].pivot, kMm);
    json["pivot_std_mm"] = json_list(std_all.segment<3>(3), kMm);
  }
  json["rms_mm"] = kMm * fit.rms_3d / std::sqrt(3.0);
  json["rms_3d_mm"] = kMm * fit.rms_3d;
  json["poses"] = estimate.residuals.size();
  json["inliers"] = fit.inliers;
  json["rotation_range_deg"] = degrees_from_radians(solution.rotation_range);
  json["condition"] = estimate.condition;
  json["correlation"] = solution.correlation;
  put_motion(json, task, solution);
  json["segments"] = Json::array();
  std::vector<std::string> names{"tip_x_mm", "tip_y_mm", "tip_z_mm"};
  for (std::size_t s = 0; s < solution.segments.size(); ++s) {
    const std::string label = label_of(task, s);
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("pivot_{}_{}_mm", label, axis));
    json["segments"].push_back(
        segment_json(solution.segments[s], label, std_all.segment<3>(3 + 3 * static_cast<Eigen::Index>(s))));
  }
  json["std"] = Json{{"tip_mm", json_list(std_all.head<3>(), kMm)}};
  json["covariance"] =
      json_covariance(names, estimate.covariance, Eigen::VectorXd::Constant(std_all.size(), kMm));
  json["warnings"] =
      warnings_of(task, solution, estimate.covariance.topLeftCorner<3, 3>(), fit.rms_3d, repeats);
  add_times(task.poses, json["segments"]);
  return json;
}

}  // namespace

Expected<PivotFindings> find_pivot(PivotTask task) {
  const std::size_t repeats = device::drop_repeats(task.poses, reading_of_pose);
  // Neighbours in time share errors, wherever their rows stand.
  if (std::all_of(task.poses.begin(), task.poses.end(),
                  [](const auto& pose) { return pose.time_s.has_value(); }))
    std::stable_sort(task.poses.begin(), task.poses.end(),
                     [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  if (task.find_rests)
    if (const auto done = find_segments(task); !done) return tl::unexpected(done.error());
  auto estimate = calibrate_pivot(task.poses, task.how);
  if (!estimate) {
    Error error = estimate.error();
    if (repeats > 0) error.message += "; " + device::repeats_warning(repeats);
    if (const auto other = other_reading(task, std::numeric_limits<double>::infinity()); !other.empty())
      error.message += "; " + other;
    return tl::unexpected(std::move(error));
  }
  Json json = to_json(task, *estimate, repeats);
  return PivotFindings{std::move(*estimate), std::move(task.segments), std::move(json)};
}

}  // namespace palpate::calibration::findings
