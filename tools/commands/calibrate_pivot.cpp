#include <algorithm>
#include <memory>

#include "palpate/calibration/pivot.h"
#include "palpate/calibration/pivot_rests.h"
#include "palpate/core/csv.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_model.h"
#include "palpate/device/arm_samples.h"
#include "palpate/device/pose_file.h"
#include "palpate/device/repeats.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

// A held tip wanders by 1-2 mm; beyond this it did not rest.
constexpr double kRestlessTip = 0.004;  // m, rms

constexpr double kNearTip = 0.001;  // m; nearer, metres stand where millimetres are said

constexpr double kShiftThatMatters = 0.0001;  // m

struct PivotArguments {
  ResultOptions result;
  std::string poses, transform, method = "algebraic", segments, pivots_out, arm, marker = "tip";
  std::vector<double> tip_mm;
  bool with_arm = false;
};

// The tip's places as the arm saw them: by its calibration where the rig has one, else by its nominal
// kinematics.
Expected<void> add_arm_motion(const PivotArguments& options, const rig::Rig& rig,
                              std::vector<calibration::PivotPose>& poses) {
  const bool calibrated = rig.arm && options.arm.empty();
  Expected<device::ArmModel> model = calibrated ? rig.arm->model : rig.nominal_arm;
  if (!options.arm.empty()) model = device::read_arm_model(options.arm);
  if (!model) return tl::unexpected(model.error());
  const auto samples = device::read_arm_samples(options.poses);
  if (!samples) return tl::unexpected(samples.error());
  if (samples->observations.size() != poses.size())
    return wrong_use("{}: --with-arm needs one row of joint readings per pose", options.poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto& joints = samples->observations[i].joints;
    if (joints.size() != model->joint_count())
      return wrong_use("{}: has {} joint columns, the arm {} has {} joints", options.poses, joints.size(),
                       model->name, model->joint_count());
    const Eigen::VectorXd theta = calibrated ? Eigen::VectorXd(rig.arm->correction.apply(joints)) : joints;
    poses[i].motion = device::arm_tip(*model, theta).m;
  }
  return {};
}

Expected<void> write_pivots(const std::string& path, const device::PoseFile& file,
                            const Estimate<calibration::PivotSolution>& estimate) {
  // One pose for each pivot says nothing of its errors; readers of the file would stumble over a "nan".
  const bool with_std = estimate.covariance.allFinite();
  std::vector<std::string> header{"label", "x_mm", "y_mm", "z_mm"};
  if (with_std) header.insert(header.end(), {"std_x_mm", "std_y_mm", "std_z_mm"});
  CsvWriter csv(header);
  for (std::size_t s = 0; s < estimate.value.segments.size(); ++s) {
    std::vector<std::string> cells{file.segments.empty() ? std::string("1") : file.segments[s]};
    for (int i = 0; i < 3; ++i) cells.push_back(number_text(kMm * estimate.value.segments[s].pivot[i]));
    for (Eigen::Index i = 0; with_std && i < 3; ++i)
      cells.push_back(
          number_text(kMm * estimate.standard_deviation(3 + 3 * static_cast<Eigen::Index>(s) + i)));
    csv.row(cells);
  }
  return write_file(path, csv.content());
}

// A pose is the same if marker, tip and segment are; when it was read does not matter.
device::Reading reading_of_pose(const calibration::PivotPose& pose) {
  return device::Reading()
      .add(pose.rotation.coeffs())
      .add(pose.translation)
      .add(pose.segment)
      .add_if(pose.motion);
}

constexpr const char* kFindThem = "auto";  // instead of a column: where the tip rested shows in the poses

// The segments found by themselves, and their names.
Expected<void> find_segments(device::PoseFile& file, std::vector<calibration::PivotPose>& poses) {
  const auto rests = calibration::find_pivot_rests(poses);
  if (!rests) return refused("{}: {}", file.source, rests.error().message);
  calibration::put_segments(*rests, poses);
  file.segments.clear();
  for (std::size_t s = 0; s < rests->size(); ++s) file.segments.push_back(std::to_string(s + 1));
  return {};
}

// When each segment began and ended; nothing where the poses have no times.
void add_times(const std::vector<calibration::PivotPose>& poses, Json& segments) {
  for (const auto& pose : poses) {
    if (pose.segment < 0 || !pose.time_s) continue;
    Json& entry = segments[static_cast<std::size_t>(pose.segment)];
    if (!entry.contains("from_s")) entry["from_s"] = *pose.time_s;
    entry["to_s"] = *pose.time_s;
  }
}

// A file whose poses never agree may hold several pivots, in a column that was not named.
std::string hint_of_segments(const PivotArguments& options, const device::PoseFile& file) {
  if (!options.segments.empty()) return "";
  for (const auto& name : file.table.header)
    if (name == "segment" || name == "pivot" || name == "landmark")
      return fmt::format("; its column '{}' may number the pivots (--segments {})", excerpt(name),
                         excerpt(name));
  return file.has_time ? "; several pivots in one file are found by --segments auto" : "";
}

Json to_json(const PivotArguments& options, const device::PoseFile& file,
             const Estimate<calibration::PivotSolution>& estimate, std::size_t repeats) {
  const calibration::PivotSolution& solution = estimate.value;
  const auto std_all = standard_deviations(estimate.covariance);
  std::size_t inliers = 0;
  double square = 0.0;
  for (std::size_t i = 0; i < estimate.residuals.size(); ++i) {
    if (!estimate.inlier.empty() && !estimate.inlier[i]) continue;
    ++inliers;
    square += estimate.residuals[i].squaredNorm();
  }
  const double rms_3d = std::sqrt(square / static_cast<double>(inliers));
  Json json;
  json["method"] = options.method;
  json["tip_mm"] = json_list(solution.tip, kMm);
  json["tip_std_mm"] = json_list(std_all.head<3>(), kMm);
  if (solution.segments.size() == 1) {
    json["pivot_mm"] = json_list(solution.segments[0].pivot, kMm);
    json["pivot_std_mm"] = json_list(std_all.segment<3>(3), kMm);
  }
  json["rms_mm"] = kMm * rms_3d / std::sqrt(3.0);
  json["rms_3d_mm"] = kMm * rms_3d;
  json["poses"] = estimate.residuals.size();
  json["inliers"] = inliers;
  json["rotation_range_deg"] = degrees_from_radians(solution.rotation_range);
  json["condition"] = estimate.condition;
  json["correlation"] = solution.correlation;
  if (solution.bootstrap_block > 0) {
    json["bootstrap_tip_std_mm"] = json_list(solution.bootstrap_std, kMm);
    json["bootstrap_block_poses"] = solution.bootstrap_block;
    json["shared_error_mm"] = kMm * solution.field_sd;
  }
  if (solution.tip_motion > 0.0) json["tip_motion_rms_mm"] = kMm * solution.tip_motion;
  if (solution.tip_shift) json["tip_shift_by_motion_mm"] = json_list(*solution.tip_shift, kMm);
  if (solution.tip_scatter.trace() > 0.0)
    json["tip_scatter_mm"] = json_list(standard_deviations(solution.tip_scatter), kMm);
  if (options.with_arm) json["arm_in_world_qwxyz"] = json_quaternion(solution.R_world_arm);
  if (options.with_arm) json["delay_s"] = solution.delay;
  json["segments"] = Json::array();
  std::vector<std::string> names{"tip_x_mm", "tip_y_mm", "tip_z_mm"};
  for (std::size_t s = 0; s < solution.segments.size(); ++s) {
    const auto& segment = solution.segments[s];
    const std::string label = file.segments.empty() ? "1" : file.segments[s];
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("pivot_{}_{}_mm", label, axis));
    Json entry;
    entry["label"] = label;
    entry["poses"] = segment.poses;
    entry["tip_mm"] = segment.own_tip ? json_list(*segment.own_tip, kMm) : Json();
    entry["tip_std_mm"] =
        segment.own_covariance ? json_list(standard_deviations(*segment.own_covariance), kMm) : Json();
    entry["pivot_mm"] = json_list(segment.pivot, kMm);
    entry["pivot_std_mm"] = json_list(std_all.segment<3>(3 + 3 * static_cast<Eigen::Index>(s)), kMm);
    entry["rms_mm"] = kMm * segment.own_rms;
    entry["rms_common_tip_mm"] = kMm * segment.rms;
    json["segments"].push_back(entry);
  }
  json["std"] = Json{{"tip_mm", json_list(std_all.head<3>(), kMm)}};
  json["covariance"] =
      json_covariance(names, estimate.covariance, Eigen::VectorXd::Constant(std_all.size(), kMm));
  json["warnings"] = Json::array();
  if (repeats > 0) json["warnings"].push_back(device::repeats_warning(repeats));
  if (solution.tip.norm() < kNearTip)
    json["warnings"].push_back(fmt::format(
        "the tip lies only {:.4f} mm from its marker's origin: check the unit in the header (_mm or _m)",
        kMm * solution.tip.norm()));
  if (rms_3d > kRestlessTip)
    json["warnings"].push_back(
        "the poses agree badly: the tip did not rest, or the file holds several pivots (--segments COLUMN, "
        "or auto)");
  if (solution.tip_shift && solution.tip_shift->norm() > kShiftThatMatters)
    json["warnings"].push_back(
        fmt::format("the arm's readings show that the tip moved by {:.2f} mm rms, which puts it {:.2f} mm "
                    "off; subtract it with --with-arm",
                    kMm * solution.tip_motion, kMm * solution.tip_shift->norm()));
  json["data"] = Json{{"file", file.source}, {"hash", file.hash}};
  return json;
}

Expected<void> run_pivot(const PivotArguments& options) {
  if (options.with_arm && options.method == "sphere")
    return wrong_use("--with-arm goes with --method algebraic or robust, not sphere");
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  const bool find = options.segments == kFindThem;
  auto file = device::read_poses(
      options.poses, {.transform = options.transform, .segment_column = find ? "" : options.segments});
  if (!file) return tl::unexpected(file.error());
  std::vector<calibration::PivotPose> poses;
  for (const auto& pose : file->poses)
    poses.push_back({pose.rotation, pose.translation, options.segments.empty() || find ? 0 : pose.segment,
                     std::nullopt, file->has_time ? std::optional(pose.time_s) : std::nullopt});
  if (options.with_arm)
    if (const auto done = add_arm_motion(options, *rig, poses); !done) return done;
  if (!options.arm.empty())
    if (const auto model = device::read_arm_model(options.arm); !model) return tl::unexpected(model.error());
  // Readings that lie beside the poses show whether the tip rested, asked for or not.
  if (!options.with_arm && options.marker == "tip")
    if (!add_arm_motion(options, *rig, poses))
      for (auto& pose : poses) pose.motion.reset();
  const std::size_t repeats = device::drop_repeats(poses, reading_of_pose);
  // Neighbours in time share errors, wherever their rows stand.
  if (file->has_time)
    std::stable_sort(poses.begin(), poses.end(),
                     [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  if (find)
    if (const auto done = find_segments(*file, poses); !done) return done;
  calibration::PivotCalibrationOptions how;
  how.method = options.method == "sphere"   ? calibration::PivotMethod::sphere
               : options.method == "robust" ? calibration::PivotMethod::robust
                                            : calibration::PivotMethod::algebraic;
  how.with_motion = options.with_arm;
  how.shared_errors = true;
  // A calibrated arm's gains are known to a tenth of a percent; what is left is flexing.
  if (rig->arm && options.arm.empty()) how.motion_strain = 0.005;
  if (!options.tip_mm.empty())
    how.given_tip = Vector3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]) / kMm;
  const auto estimate = calibration::calibrate_pivot(poses, how);
  if (!estimate)
    return refused("{}: {}{}", file->source, estimate.error().message, hint_of_segments(options, *file));
  if (!options.pivots_out.empty())
    if (const auto done = write_pivots(options.pivots_out, *file, *estimate); !done) return done;
  Result result{to_json(options, *file, *estimate, repeats), {}, {}};
  add_times(poses, result.json["segments"]);
  if (find) result.summary.push_back(fmt::format("rests          {} found", file->segments.size()));
  result.summary.push_back(fmt::format("tip in marker  {} mm  +- {}", shown(estimate->value.tip, kMm),
                                       shown(standard_deviations(estimate->covariance).head<3>(), kMm)));
  result.summary.push_back(
      fmt::format("residual       {:.4f} mm rms per component, {} of {} poses, turning by {:.1f} deg",
                  result.json["rms_mm"].get<double>(), result.json["inliers"].get<int>(),
                  result.json["poses"].get<int>(), degrees_from_radians(estimate->value.rotation_range)));
  for (const auto& warning : result.json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  result.store = [&](rig::Rig& target) {
    auto& place = options.marker == "pointer" ? target.pointer_pivot : target.tip_pivot;
    place = rig::PivotCalibration{
        estimate->value.tip,
        estimate->covariance.topLeftCorner<3, 3>(),
        {rig::utc_now(), file->hash, options.method, result.json["rms_mm"].get<double>()}};
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_pivot(CLI::App& calibrate) {
  auto options = std::make_shared<PivotArguments>();
  auto* command =
      calibrate.add_subcommand("pivot", "The tip in its marker's frame, from poses around a resting tip");
  command->add_option("--poses", options->poses, "Marker poses: CSV, .igs.mha, or a folder of matrices")
      ->type_name("FILE");
  command->add_option("--transform", options->transform, "Which transform of an .igs.mha sequence")
      ->type_name("AToB");
  command->add_option("--method", options->method, "How the tip is found")
      ->check(one_of({"algebraic", "sphere", "robust"}))
      ->capture_default_str();
  command
      ->add_option(
          "--segments", options->segments,
          "Column that numbers the pivots (0 or empty = in none); auto: they are found by themselves")
      ->type_name("COLUMN|auto");
  command->add_option("--tip-mm", options->tip_mm, "A known tip: estimate the pivots only")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command->add_option("--pivots-out", options->pivots_out, "Write the pivots as a point list")
      ->type_name("FILE");
  command->add_flag("--with-arm", options->with_arm,
                    "Subtract the tip's own motion, from the file's joint readings");
  command
      ->add_option("--arm", options->arm,
                   "Arm model for --with-arm (default: the rig's, else phantom-premium-1.5)")
      ->type_name("MODEL");
  command->add_option("--marker", options->marker, "Whose tip it is, for --rig and --out")
      ->check(one_of({"tip", "pointer"}))
      ->capture_default_str();
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--poses", options->poses, [options] {
    return options->marker == "pointer" ? std::string("pointer_pivot") : std::string("pivot");
  });
  tables->add_options(*command);
  on(command, tables, [options] { return run_pivot(*options); });
}

}  // namespace palpate::tools::commands
