#include <algorithm>
#include <memory>
#include <sstream>

#include "palpate/calibration/arm_motion.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/repeats.h"
#include "tools/commands/arm_result.h"
#include "tools/commands/command.h"

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

Expected<void> run_arm(const ArmArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  if (options.arm.empty() && options.result.rig.empty())
    return wrong_use(
        "--arm is required (phantom-premium-1.5 or a file), or a rig file that knows the arm (--rig)");
  auto model = device::read_arm_model(options.arm.empty() ? device::ArmModel{}.name : options.arm);
  if (!model) return tl::unexpected(model.error());
  if (options.arm.empty()) model->lengths = rig->nominal_lengths;
  if (model->kind == device::ArmModel::Kind::dh &&
      !(options.result.rig.empty() && options.result.out.empty()))
    return wrong_use("{}: a rig file holds arms of the PHANToM kind only; use --json", model->name);
  auto file = device::read_arm_samples(options.samples);
  if (!file) return tl::unexpected(file.error());
  const std::size_t repeats = device::drop_repeats(file->observations, reading_of_sample);
  const auto& samples = file->observations;
  const bool markers =
      std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.marker.has_value(); });

  const bool has_gimbal =
      markers && model->kind == device::ArmModel::Kind::phantom &&
      std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.gimbal.has_value(); });
  bool wants_gimbal = has_gimbal;

  calibration::ArmOptions how;
  how.method = options.method == "one-pass"      ? calibration::ArmMethod::one_pass
               : options.method == "alternating" ? calibration::ArmMethod::alternating
               : options.method == "eq7"         ? calibration::ArmMethod::eq7
                                                 : calibration::ArmMethod::joint;
  if (!options.tip_mm.empty())
    how.tip = Vector3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]) / kMm;
  if (!how.tip && rig->tip_pivot) how.tip = rig->tip_pivot->tip_in_marker;
  std::optional<calibration::ArmChoice> choice;
  const bool joint = how.method == calibration::ArmMethod::joint;
  if (options.free.empty()) {
    how.free.lengths = model->kind == device::ArmModel::Kind::phantom;
    how.free.tip = markers && joint;
    how.free.delay = joint && calibration::taken_in_motion(samples);
  } else if (options.free == "auto") {
    how.free.tip = markers && joint;
    if (!joint) return wrong_use("--free auto: chooses for the joint method, not for {}", options.method);
    auto chosen = calibration::choose_free(samples, *model, how);
    if (!chosen) return refused("{}: {}", file->source, chosen.error().message);
    how.free = chosen->free;
    choice = std::move(*chosen);
  } else {
    const auto free = parse_free(options.free);
    if (!free) return tl::unexpected(free.error());
    how.free = free->arm;
    wants_gimbal = free->gimbal;
    if (wants_gimbal && !has_gimbal)
      return wrong_use(
          "--free gimbal: needs gimbal angles (gimbal_1_deg ...) and marker poses of a PHANToM in every row "
          "of {}",
          file->source);
    if (how.free.tip && !markers)
      return wrong_use("--free tip: needs marker poses (marker_x_mm ... marker_qz), {} has none",
                       file->source);
  }

  if ((how.free.quadratic || how.free.hysteresis) &&
      !(options.result.rig.empty() && options.result.out.empty()))
    return wrong_use(
        "--free {}: a rig file holds gains and offsets, no quadratic or hysteresis terms; leave them out, or "
        "use "
        "--json without --rig and --out",
        calibration::free_text(how.free));

  const auto estimate = calibration::calibrate_arm(samples, *model, how);
  if (!estimate)
    return tl::unexpected(Error{estimate.error().kind, file->source + ": " + estimate.error().message});
  const calibration::ArmSolution& arm = estimate->value;
  constexpr double kNoArm = 0.12, kPoor = 0.03;  // misfit as a share of the motion
  const auto misfit = calibration::arm_misfit(arm, samples);
  if (joint && !(misfit.share() <= kNoArm))
    return refused(
        "{}: arm: half of the samples lie more than {:.1f} mm off the best fit, in a motion of {:.0f} mm: "
        "this "
        "is not a {}; check the units, the order of the joints and that rows hold one moment each",
        file->source, mm_from_metres(misfit.error), mm_from_metres(misfit.spread), model->name);
  std::optional<Estimate<calibration::GimbalSolution>> gimbal;
  if (wants_gimbal) {
    auto fitted =
        calibration::calibrate_gimbal(calibration::with_delay_removed(samples, arm.delay_s), *estimate);
    if (!fitted)
      return tl::unexpected(Error{fitted.error().kind, file->source + ": " + fitted.error().message});
    gimbal = std::move(*fitted);
  }
  const auto uncorrected = calibration::uncorrected_arm(samples, *model, how);
  if (!uncorrected) return tl::unexpected(uncorrected.error());
  const auto unseen = judge(options, samples, *model, how, arm, uncorrected->value);
  if (!unseen)
    return options.test.empty()
               ? tl::unexpected(
                     Error{unseen.error().kind, fmt::format("{}: {} (a fifth of the samples is held out to "
                                                            "judge by; --test FILE judges by others)",
                                                            file->source, unseen.error().message)})
               : tl::unexpected(unseen.error());
  const auto regions = calibration::held_out_by_region(samples, *model, how);

  ArmFindings found{.method = options.method,
                    .free = calibration::free_text(how.free) + (gimbal ? ",gimbal" : ""),
                    .samples = *file,
                    .estimate = *estimate,
                    .gimbal = gimbal,
                    .unseen = unseen->errors,
                    .unseen_uncorrected = unseen->uncorrected,
                    .unseen_from = unseen->from,
                    .regions = regions ? regions->means : std::vector<double>{},
                    .choice = choice,
                    .warnings = {}};
  if (repeats > 0) found.warnings.push_back(device::repeats_warning(repeats));
  if (unseen->seen > 0)
    found.warnings.push_back(
        fmt::format("{} of {} stand among the samples too, so they test nothing; record others for --test",
                    counted(unseen->seen, "row"), unseen->from));
  if (gimbal)
    if (const double off = degrees_from_radians(rms_per_component(calibration::gimbal_errors(
            calibration::with_delay_removed(samples, arm.delay_s), arm, gimbal->value)));
        off > kPoorGimbal)
      found.warnings.push_back(fmt::format(
          "the gimbal's angles leave the stylus {:.1f} deg rms off its marker: check their unit, their "
          "order and that of the joints",
          off));
  if (!joint && how.free.tip)
    found.warnings.push_back(
        fmt::format("method {} takes the tip as given; it was not estimated", options.method));
  if (!joint && arm.tip_known && !how.tip)
    found.warnings.push_back("no tip was given (--tip-mm): it was found with the arm's nominal kinematics");
  if (joint && misfit.share() > kPoor)
    found.warnings.push_back(fmt::format(
        "half of the samples lie more than {:.1f} mm off the best fit: free more, or check units, joint "
        "order and that rows hold one moment each",
        mm_from_metres(misfit.error)));
  if (estimate->termination == Termination::iteration_limit)
    found.warnings.push_back("the solution had not settled at the iteration limit");
  if (joint && !how.free.delay && calibration::taken_in_motion(samples))
    found.warnings.push_back(
        "the samples were taken in motion: any delay between encoders and tracker went into the errors; free "
        "it "
        "(--free ...,delay)");
  Result result;
  result.json = arm_json(found);
  result.summary = arm_summary(found, result.json);
  result.store = [&](rig::Rig& target) {
    put_into(target, found,
             {rig::utc_now(), file->hash, options.method, result.json["rms_mm"].get<double>()});
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_arm(CLI::App& calibrate) {
  auto options = std::make_shared<ArmArguments>();
  auto* command = calibrate.add_subcommand(
      "arm", "Joint correction and place of the arm, from encoder readings and the tracker");
  command->add_option("--samples", options->samples, "Joint readings with measured tips or marker poses, CSV")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--test", options->test,
                   "Samples to judge the result by; without, five folds of the samples")
      ->type_name("FILE");
  command->add_option("--arm", options->arm, "phantom-premium-1.5, or a TOML file")->type_name("MODEL");
  command->add_option("--method", options->method, "joint, or one of the 2006 paper's")
      ->check(CLI::IsMember({"joint", "eq7", "alternating", "one-pass"}))
      ->capture_default_str();
  command
      ->add_option("--free", options->free,
                   "What is estimated: of gains,offsets,lengths,tip,gimbal,quadratic,hysteresis,delay,dh; or "
                   "auto: what "
                   "lowers the error in regions not seen")
      ->type_name("LIST");
  command->add_option("--tip-mm", options->tip_mm, "The tip in its marker, from a pivot calibration")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command->add_option("--seed", options->seed, "Draws the folds")->capture_default_str();
  add_result_options(*command, options->result);
  on(command, [options] { return run_arm(*options); });
}

}  // namespace palpate::tools::commands
