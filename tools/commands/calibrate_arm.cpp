#include <memory>

#include "palpate/device/arm_kinematics.h"
#include "tools/commands/arm_result.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/files_of_others.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

namespace findings = calibration::findings;

struct ArmArguments {
  ResultOptions result;
  std::string samples, test, arm, method = "joint", free;
  std::vector<double> tip_mm, rest_readings;
  std::uint64_t seed = 1;
};

bool goes_into_a_rig(const ArmArguments& options) {
  return !(options.result.rig.empty() && options.result.out.empty());
}

Expected<device::ArmModel> nominal_arm(const ArmArguments& options, const rig::Rig& rig) {
  if (options.arm.empty() && options.result.rig.empty())
    return wrong_use(
        "--arm is required (phantom-premium-1.5 or a file), or a rig file that knows the arm (--rig)");
  if (options.arm.empty()) return rig.nominal_arm;
  auto model = device::read_arm_model(options.arm);
  if (!model) return model;
  if (goes_into_a_rig(options))
    if (auto fine = device::check_runnable(*model); !fine) return tl::unexpected(fine.error());
  return model;
}

calibration::ArmMethod method_of(const std::string& name) {
  return name == "one-pass"      ? calibration::ArmMethod::one_pass
         : name == "alternating" ? calibration::ArmMethod::alternating
         : name == "eq7"         ? calibration::ArmMethod::eq7
                                 : calibration::ArmMethod::joint;
}

Expected<findings::ArmTask> task_of(const ArmArguments& options, const rig::Rig& rig) {
  auto model = nominal_arm(options, rig);
  if (!model) return tl::unexpected(model.error());
  auto samples = read_arm_samples(options.samples);
  if (!samples) return tl::unexpected(samples.error());
  findings::ArmTask task{.nominal = std::move(*model),
                         .samples = std::move(*samples),
                         .method = method_of(options.method),
                         .free = options.free,
                         .tip = {},
                         .test = {},
                         .seed = options.seed,
                         .for_rig = goes_into_a_rig(options)};
  if (!options.tip_mm.empty())
    task.tip = Vector3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]) / kMm;
  if (!task.tip && rig.tip_pivot) task.tip = rig.tip_pivot->tip_in_marker;
  if (options.test.empty()) return task;
  auto test = read_arm_samples(options.test);
  if (!test) return tl::unexpected(test.error());
  task.test = std::move(*test);
  return task;
}

Expected<void> run_arm(const ArmArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  auto task = task_of(options, *rig);
  if (!task) return tl::unexpected(task.error());
  const auto found = findings::find_arm(std::move(*task));
  if (!found) return tl::unexpected(found.error());
  Result result{found->json, arm_summary(*found), {}};
  result.json["data"] = Json{{"file", found->samples.source}, {"hash", found->samples.hash}};
  std::optional<device::JointVector> rest;
  if (!options.rest_readings.empty()) {
    const auto given = rest_readings_of(options.rest_readings, found->estimate.value.model);
    if (!given) return tl::unexpected(given.error());
    rest = *given;
  }
  result.store = [&](rig::Rig& target) {
    put_into(target, *found,
             {rig::utc_now(), found->samples.hash, options.method, result.json["rms_mm"].get<double>()});
    if (!rest) return;
    target.arm->rest_readings = *rest;
    target.arm->rest_known = true;
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_arm(CLI::App& calibrate) {
  auto options = std::make_shared<ArmArguments>();
  auto* command = calibrate.add_subcommand(
      "arm", "Joint correction and place of the arm, from encoder readings and the tracker");
  command->add_option("--samples", options->samples, "Joint readings with measured tips or marker poses, CSV")
      ->type_name("FILE");
  command
      ->add_option("--test", options->test,
                   "Samples to judge the result by; without, five folds of the samples")
      ->type_name("FILE");
  command
      ->add_option(
          "--arm", options->arm,
          "phantom-premium-1.5, laboratory-delta, or a TOML file: a chain, or an arm that states its place")
      ->type_name("MODEL");
  command->add_option("--method", options->method, "joint, or one of the 2006 paper's")
      ->check(one_of({"joint", "eq7", "alternating", "one-pass"}))
      ->capture_default_str();
  command
      ->add_option(
          "--free", options->free,
          "What is estimated: of gains,offsets,lengths,tip,gimbal,quadratic,hysteresis,delay,dh, of an arm "
          "that states its place of correction,tip,delay; or auto: what lowers the error in regions not seen")
      ->type_name("LIST");
  command->add_option("--tip-mm", options->tip_mm, "The tip in its marker, from a pivot calibration")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command
      ->add_option(
          "--rest-readings", options->rest_readings,
          "What the arm read at rest, deg (of an arm that states its place mm), for the rig: `rig check` and "
          "`verify` compare with it")
      ->delimiter(',')
      ->expected(3, device::kMostJoints)
      ->type_name("PSI1,PSI2,PSI3[,...]");
  command->add_option("--seed", options->seed, "Draws the folds")->capture_default_str();
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--samples", options->samples, "arm");
  tables->add("--test", options->test, "arm_test", false);
  tables->add_options(*command);
  on(command, tables, [options] { return run_arm(*options); });
}

}  // namespace palpate::tools::commands
