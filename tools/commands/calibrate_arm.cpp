#include <algorithm>
#include <memory>
#include <sstream>

#include "palpate/calibration/arm_motion.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_kinematics.h"
#include "palpate/device/repeats.h"
#include "tools/commands/arm_result.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

constexpr int kFolds = 5;
constexpr double kPoorGimbal = 1.0;  // deg

struct ArmArguments {
  ResultOptions result;
  std::string samples, test, arm, method = "joint", free;
  std::vector<double> tip_mm;
  std::uint64_t seed = 1;
};

// What is estimated: of the arm, and whether the gimbal is beside it.
struct FreeList {
  calibration::ArmFree arm;
  bool gimbal = false;
};

Expected<FreeList> parse_free(const std::string& list) {
  FreeList all{{.gains = false, .offsets = false, .lengths = false, .tip = false}, false};
  calibration::ArmFree& free = all.arm;
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) {
    if (name == "gains")
      free.gains = true;
    else if (name == "offsets")
      free.offsets = true;
    else if (name == "lengths")
      free.lengths = true;
    else if (name == "tip")
      free.tip = true;
    else if (name == "dh")
      free.dh = true;
    else if (name == "gimbal")
      all.gimbal = true;
    else if (name == "quadratic")
      free.quadratic = true;
    else if (name == "hysteresis")
      free.hysteresis = true;
    else if (name == "delay")
      free.delay = true;
    else
      return wrong_use(
          "--free {}: unknown; a list of gains, offsets, lengths, tip, gimbal, quadratic, hysteresis, delay, "
          "dh is expected, or auto",
          name);
  }
  return all;
}

// A sample is the same if every device read the same; when does not matter.
device::Reading reading_of_sample(const device::ArmObservation& sample) {
  device::Reading reading;
  reading.add(sample.joints).add_if(sample.gimbal);
  if (sample.marker) reading.add(sample.marker->rotation.coeffs()).add(sample.marker->translation);
  if (sample.tip) reading.add(sample.tip->m);
  return reading;
}

// Errors on samples that the calibration has not seen: of the test file, or of five folds drawn by the seed.
struct Unseen {
  std::string from;
  std::vector<Vector3> errors, uncorrected;
  std::size_t seen = 0;  // of the test file's samples, those that the calibration has seen after all
};

Expected<Unseen> judge(const ArmArguments& options, const std::vector<device::ArmObservation>& samples,
                       const device::ArmModel& model, const calibration::ArmOptions& how,
                       const calibration::ArmSolution& arm, const calibration::ArmSolution& uncorrected) {
  Unseen unseen;
  if (!options.test.empty()) {
    const auto test = device::read_arm_samples(options.test);
    if (!test) return tl::unexpected(test.error());
    for (const auto& sample : test->observations) {
      if (sample.joints.size() != model.joint_count())
        return wrong_use("{}: has {} joint columns, the arm {} has {} joints", options.test,
                         sample.joints.size(), model.name, model.joint_count());
      if (arm.tip_known && !sample.marker && !sample.tip)
        return wrong_use("{}: has no measured tips", options.test);
    }
    auto both = samples, own = test->observations;
    device::drop_repeats(own, reading_of_sample);
    both.insert(both.end(), own.begin(), own.end());
    unseen.seen = device::drop_repeats(both, reading_of_sample);
    unseen.from = test->source;
    unseen.errors = calibration::arm_errors(arm, test->observations);
    unseen.uncorrected = calibration::arm_errors(uncorrected, test->observations);
    return unseen;
  }
  unseen.from = fmt::format("{} folds of the samples", kFolds);
  const auto held = calibration::held_out_by_folds(samples, model, how, options.seed, kFolds);
  if (!held) return tl::unexpected(held.error());
  unseen.errors = held->errors;
  unseen.uncorrected = calibration::arm_errors(uncorrected, samples);
  return unseen;
}

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

// The samples, and what is asked of them.
struct ArmTask {
  device::ArmModel model;  // as its maker describes it
  device::ArmSampleFile file;
  std::size_t repeats = 0;
  bool markers = false, has_gimbal = false, wants_gimbal = false;
  calibration::ArmOptions how;
  std::optional<calibration::ArmChoice> choice;

  const std::vector<device::ArmObservation>& samples() const { return file.observations; }
  bool joint() const { return how.method == calibration::ArmMethod::joint; }
  Error of_the_file(const Error& error) const { return {error.kind, file.source + ": " + error.message}; }
};

calibration::ArmMethod method_of(const std::string& name) {
  return name == "one-pass"      ? calibration::ArmMethod::one_pass
         : name == "alternating" ? calibration::ArmMethod::alternating
         : name == "eq7"         ? calibration::ArmMethod::eq7
                                 : calibration::ArmMethod::joint;
}

// What --free asks to be estimated.
Expected<void> choose_free(const std::string& asked, const std::string& method, ArmTask& task) {
  calibration::ArmFree& free = task.how.free;
  if (asked.empty()) {
    free.lengths = task.model.kind == device::ArmModel::Kind::phantom;
    free.tip = task.markers && task.joint();
    free.delay = task.joint() && calibration::taken_in_motion(task.samples());
    return {};
  }
  if (asked == "auto") {
    free.tip = task.markers && task.joint();
    if (!task.joint()) return wrong_use("--free auto: chooses for the joint method, not for {}", method);
    auto chosen = calibration::choose_free(task.samples(), task.model, task.how);
    if (!chosen) return refused("{}: {}", task.file.source, chosen.error().message);
    free = chosen->free;
    task.choice = std::move(*chosen);
    return {};
  }
  const auto list = parse_free(asked);
  if (!list) return tl::unexpected(list.error());
  free = list->arm;
  task.wants_gimbal = list->gimbal;
  if (task.wants_gimbal && !task.has_gimbal)
    return wrong_use(
        "--free gimbal: needs gimbal angles (gimbal_1_deg ...) and marker poses of a PHANToM in every row "
        "of {}",
        task.file.source);
  if (free.tip && !task.markers)
    return wrong_use("--free tip: needs marker poses (marker_x_mm ... marker_qz), {} has none",
                     task.file.source);
  return {};
}

Expected<ArmTask> task_of(const ArmArguments& options, const rig::Rig& rig) {
  auto model = nominal_arm(options, rig);
  if (!model) return tl::unexpected(model.error());
  auto file = device::read_arm_samples(options.samples);
  if (!file) return tl::unexpected(file.error());
  ArmTask task{.model = std::move(*model), .file = std::move(*file), .how = {}, .choice = {}};
  task.repeats = device::drop_repeats(task.file.observations, reading_of_sample);
  const auto all = [&](const auto& has) {
    return std::all_of(task.samples().begin(), task.samples().end(), has);
  };
  task.markers = all([](const auto& s) { return s.marker.has_value(); });
  task.has_gimbal = task.markers && task.model.kind == device::ArmModel::Kind::phantom &&
                    all([](const auto& s) { return s.gimbal.has_value(); });
  task.wants_gimbal = task.has_gimbal;
  task.how.method = method_of(options.method);
  if (!options.tip_mm.empty())
    task.how.tip = Vector3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]) / kMm;
  if (!task.how.tip && rig.tip_pivot) task.how.tip = rig.tip_pivot->tip_in_marker;
  if (auto done = choose_free(options.free, options.method, task); !done) return tl::unexpected(done.error());
  if ((task.how.free.quadratic || task.how.free.hysteresis) && goes_into_a_rig(options))
    return wrong_use(
        "--free {}: a rig file holds gains and offsets, no quadratic or hysteresis terms; leave them out, or "
        "use --json without --rig and --out",
        calibration::free_text(task.how.free));
  return task;
}

// Refused where half of the samples lie so far off that they are not this arm's.
Expected<void> check_misfit(const ArmTask& task, const calibration::ArmMisfit& misfit) {
  constexpr double kNoArm = 0.12;
  if (!task.joint() || misfit.share() <= kNoArm) return {};
  return refused(
      "{}: arm: half of the samples lie more than {:.1f} mm off the best fit, in a motion of {:.0f} mm: this "
      "is not a {}; check the units, the order of the joints and that rows hold one moment each",
      task.file.source, mm_from_metres(misfit.error), mm_from_metres(misfit.spread), task.model.name);
}

Expected<std::optional<Estimate<calibration::GimbalSolution>>> fit_gimbal(
    const ArmTask& task, const Estimate<calibration::ArmSolution>& estimate) {
  if (!task.wants_gimbal) return std::nullopt;
  auto fitted = calibration::calibrate_gimbal(
      calibration::with_delay_removed(task.samples(), estimate.value.delay_s), estimate);
  if (!fitted) return tl::unexpected(task.of_the_file(fitted.error()));
  return std::optional(std::move(*fitted));
}

Expected<Unseen> judge(const ArmArguments& options, const ArmTask& task,
                       const calibration::ArmSolution& arm) {
  const auto uncorrected = calibration::uncorrected_arm(task.samples(), task.model, task.how);
  if (!uncorrected) return tl::unexpected(uncorrected.error());
  auto unseen = judge(options, task.samples(), task.model, task.how, arm, uncorrected->value);
  if (unseen || !options.test.empty()) return unseen;
  return tl::unexpected(Error{
      unseen.error().kind,
      fmt::format("{}: {} (a fifth of the samples is held out to judge by; --test FILE judges by others)",
                  task.file.source, unseen.error().message)});
}

// What a person should know of the result.
std::vector<std::string> warnings_of(const ArmTask& task, const ArmFindings& found, const Unseen& unseen,
                                     const calibration::ArmMisfit& misfit) {
  constexpr double kPoor = 0.03;  // misfit as a share of the motion
  const calibration::ArmSolution& arm = found.estimate.value;
  std::vector<std::string> warnings;
  if (task.repeats > 0) warnings.push_back(device::repeats_warning(task.repeats));
  if (unseen.seen > 0)
    warnings.push_back(
        fmt::format("{} of {} stand among the samples too, so they test nothing; record others for --test",
                    counted(unseen.seen, "row"), unseen.from));
  if (found.gimbal)
    if (const double off = degrees_from_radians(rms_per_component(calibration::gimbal_errors(
            calibration::with_delay_removed(task.samples(), arm.delay_s), arm, found.gimbal->value)));
        off > kPoorGimbal)
      warnings.push_back(fmt::format(
          "the gimbal's angles leave the stylus {:.1f} deg rms off its marker: check their unit, their "
          "order and that of the joints",
          off));
  if (!task.joint() && task.how.free.tip)
    warnings.push_back(fmt::format("method {} takes the tip as given; it was not estimated", found.method));
  if (!task.joint() && arm.tip_known && !task.how.tip)
    warnings.push_back("no tip was given (--tip-mm): it was found with the arm's nominal kinematics");
  if (task.joint() && misfit.share() > kPoor)
    warnings.push_back(fmt::format(
        "half of the samples lie more than {:.1f} mm off the best fit: free more, or check units, joint "
        "order and that rows hold one moment each",
        mm_from_metres(misfit.error)));
  if (found.estimate.termination == Termination::iteration_limit)
    warnings.push_back("the solution had not settled at the iteration limit");
  if (task.joint() && !task.how.free.delay && calibration::taken_in_motion(task.samples()))
    warnings.push_back(
        "the samples were taken in motion: any delay between encoders and tracker went into the errors; free "
        "it (--free ...,delay)");
  return warnings;
}

Expected<void> run_arm(const ArmArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  const auto task = task_of(options, *rig);
  if (!task) return tl::unexpected(task.error());
  const auto estimate = calibration::calibrate_arm(task->samples(), task->model, task->how);
  if (!estimate) return tl::unexpected(task->of_the_file(estimate.error()));
  const auto misfit = calibration::arm_misfit(estimate->value, task->samples());
  if (auto fine = check_misfit(*task, misfit); !fine) return fine;
  const auto gimbal = fit_gimbal(*task, *estimate);
  if (!gimbal) return tl::unexpected(gimbal.error());
  const auto unseen = judge(options, *task, estimate->value);
  if (!unseen) return tl::unexpected(unseen.error());
  const auto regions = calibration::held_out_by_region(task->samples(), task->model, task->how);
  ArmFindings found{.method = options.method,
                    .free = calibration::free_text(task->how.free) + (*gimbal ? ",gimbal" : ""),
                    .nominal = task->model,
                    .samples = task->file,
                    .estimate = *estimate,
                    .gimbal = *gimbal,
                    .unseen = unseen->errors,
                    .unseen_uncorrected = unseen->uncorrected,
                    .unseen_from = unseen->from,
                    .regions = regions ? regions->means : std::vector<double>{},
                    .choice = task->choice,
                    .warnings = {}};
  found.warnings = warnings_of(*task, found, *unseen, misfit);
  Result result;
  result.json = arm_json(found);
  result.summary = arm_summary(found, result.json);
  result.store = [&](rig::Rig& target) {
    put_into(target, found,
             {rig::utc_now(), task->file.hash, options.method, result.json["rms_mm"].get<double>()});
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
  command->add_option("--arm", options->arm, "phantom-premium-1.5, or a TOML file")->type_name("MODEL");
  command->add_option("--method", options->method, "joint, or one of the 2006 paper's")
      ->check(one_of({"joint", "eq7", "alternating", "one-pass"}))
      ->capture_default_str();
  command
      ->add_option("--free", options->free,
                   "What is estimated: of gains,offsets,lengths,tip,gimbal,quadratic,hysteresis,delay,dh; or "
                   "auto: what lowers the error in regions not seen")
      ->type_name("LIST");
  command->add_option("--tip-mm", options->tip_mm, "The tip in its marker, from a pivot calibration")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command->add_option("--seed", options->seed, "Draws the folds")->capture_default_str();
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--samples", options->samples, "arm");
  tables->add("--test", options->test, "arm_test", false);
  tables->add_options(*command);
  on(command, tables, [options] { return run_arm(*options); });
}

}  // namespace palpate::tools::commands
