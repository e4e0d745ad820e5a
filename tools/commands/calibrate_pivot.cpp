#include <memory>

#include "palpate/calibration/findings/pivot.h"
#include "palpate/core/csv.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_model.h"
#include "palpate/device/arm_samples.h"
#include "palpate/device/pose_file.h"
#include "palpate/formats/tables.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/files_of_others.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

namespace findings = calibration::findings;

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
  const auto samples = formats::read_arm_samples(options.poses);
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

std::string pivots_text(const findings::PivotFindings& found) {
  const auto& estimate = found.estimate;
  // One pose for each pivot says nothing of its errors; readers of the file would stumble over a "nan".
  const bool with_std = estimate.covariance.allFinite();
  std::vector<std::string> header{"label", "x_mm", "y_mm", "z_mm"};
  if (with_std) header.insert(header.end(), {"std_x_mm", "std_y_mm", "std_z_mm"});
  CsvWriter csv(header);
  for (std::size_t s = 0; s < estimate.value.segments.size(); ++s) {
    std::vector<std::string> cells{found.segments.empty() ? std::string("1") : found.segments[s]};
    for (int i = 0; i < 3; ++i) cells.push_back(number_text(kMm * estimate.value.segments[s].pivot[i]));
    for (Eigen::Index i = 0; with_std && i < 3; ++i)
      cells.push_back(
          number_text(kMm * estimate.standard_deviation(3 + 3 * static_cast<Eigen::Index>(s) + i)));
    csv.row(cells);
  }
  return csv.content();
}

constexpr const char* kFindThem = "auto";  // instead of a column: where the tip rested shows in the poses

// A file whose poses never agree may hold several pivots, in a column that was not named.
std::string hint_of_segments(const PivotArguments& options, const device::PoseFile& file,
                             const Error& error) {
  const bool restless =
      error.message.ends_with("one pivot only is in them") || error.message.ends_with("the tip did not rest");
  if (!options.segments.empty() || !restless) return "";
  for (const auto& name : file.table.header)
    if (name == "segment" || name == "pivot" || name == "landmark")
      return fmt::format("; its column '{}' may number the pivots (--segments {})", excerpt(name),
                         excerpt(name));
  return file.has_time ? "; several pivots in one file are found by --segments auto" : "";
}

Expected<void> run_pivot(const PivotArguments& options) {
  if (options.with_arm && options.method == "sphere")
    return wrong_use("--with-arm goes with --method algebraic or robust, not sphere");
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  const bool find = options.segments == kFindThem;
  auto file = read_poses(options.poses,
                         {.transform = options.transform, .segment_column = find ? "" : options.segments});
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
  findings::PivotTask task{.poses = std::move(poses), .segments = file->segments, .find_rests = find};
  auto& how = task.how;
  how.method = options.method == "sphere"   ? calibration::PivotMethod::sphere
               : options.method == "robust" ? calibration::PivotMethod::robust
                                            : calibration::PivotMethod::algebraic;
  how.with_motion = options.with_arm;
  if (rig->arm && options.arm.empty()) how.motion_strain = findings::kStrainOfCalibratedArm;
  if (!options.tip_mm.empty())
    how.given_tip = Vector3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]) / kMm;
  const auto found = findings::find_pivot(std::move(task));
  if (!found)
    return refused("{}: {}{}", file->source, found.error().message,
                   hint_of_segments(options, *file, found.error()));
  const auto& estimate = found->estimate;
  Result result{found->json, {}, {}};
  if (!options.pivots_out.empty()) result.tables.push_back({options.pivots_out, pivots_text(*found)});
  result.json["data"] = Json{{"file", file->source}, {"hash", file->hash}};
  if (find) result.summary.push_back(fmt::format("rests          {} found", found->segments.size()));
  result.summary.push_back(fmt::format("tip in marker  {} mm  +- {}", shown(estimate.value.tip, kMm),
                                       shown(standard_deviations(estimate.covariance).head<3>(), kMm)));
  result.summary.push_back(
      fmt::format("residual       {:.4f} mm rms per component, {} of {} poses, turning by {:.1f} deg",
                  result.json["rms_mm"].get<double>(), result.json["inliers"].get<int>(),
                  result.json["poses"].get<int>(), degrees_from_radians(estimate.value.rotation_range)));
  if (const auto& before = options.marker == "pointer" ? rig->pointer_pivot : rig->tip_pivot; before)
    if (auto worse = warning_of_worse("this tip", before->tip_in_marker, before->covariance,
                                      estimate.covariance.topLeftCorner<3, 3>());
        !worse.empty())
      result.json["warnings"].push_back(worse);
  for (const auto& warning : result.json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  result.store = [&](rig::Rig& target) {
    auto& place = options.marker == "pointer" ? target.pointer_pivot : target.tip_pivot;
    place = rig::PivotCalibration{
        estimate.value.tip,
        estimate.covariance.topLeftCorner<3, 3>(),
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
