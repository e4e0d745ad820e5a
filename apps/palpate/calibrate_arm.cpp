#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <sstream>

#include "apps/palpate/command.h"
#include "apps/palpate/result_output.h"
#include "palpate/calibration/arm_validation.h"
#include "palpate/calibration/gimbal.h"
#include "palpate/core/random.h"
#include "palpate/core/units.h"

namespace palpate::app {
namespace {

constexpr int kFolds = 5;

struct ArmArguments {
  ResultOptions result;
  std::string samples, test, arm, method = "joint", free;
  std::vector<double> tip_mm;
  std::uint64_t seed = 1;
};

// What is estimated: of the arm, and whether the gimbal is beside it.
struct FreeList {
  ArmFree arm;
  bool gimbal = false;
};

Expected<FreeList> parse_free(const std::string& list) {
  FreeList all{{false, false, false, false, false}, false};
  ArmFree& free = all.arm;
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
    else if (name == "quadratic" || name == "hysteresis" || name == "delay")
      return wrong_use(
          "--free {}: not available in this version; gains, offsets, lengths, tip, gimbal and dh are", name);
    else
      return wrong_use(
          "--free {}: unknown; a list of gains, offsets, lengths, tip, gimbal, dh is expected, or auto",
          name);
  }
  return all;
}

// The set with the smallest error in regions it has not seen; a larger set must win by 1 %.
Expected<ArmFree> choose_free(const std::vector<ArmObservation>& samples, const ArmModel& model,
                              ArmOptions how) {
  const bool dh = model.kind == ArmModel::Kind::dh;
  std::vector<ArmFree> sets{{true, true, false, how.free.tip, false}, {true, true, !dh, how.free.tip, dh}};
  ArmFree best = sets[0];
  double least = std::numeric_limits<double>::infinity();
  for (const auto& set : sets) {
    how.free = set;
    const auto means = held_out_by_region(samples, model, how);
    if (!means) {
      if (least == std::numeric_limits<double>::infinity()) return tl::unexpected(means.error());
      continue;
    }
    const double mean =
        std::accumulate(means->begin(), means->end(), 0.0) / static_cast<double>(means->size());
    if (mean < 0.99 * least) {
      least = mean;
      best = set;
    }
  }
  return best;
}

std::string free_text(const ArmFree& free, bool gimbal) {
  std::string text;
  for (const auto& [on, name] : {std::pair{free.gains, "gains"},
                                 {free.offsets, "offsets"},
                                 {free.lengths, "lengths"},
                                 {free.tip, "tip"},
                                 {gimbal, "gimbal"},
                                 {free.dh, "dh"}})
    if (on) text += (text.empty() ? "" : ",") + std::string(name);
  return text;
}

// Errors on samples that the calibration has not seen: of the test file, or of five folds drawn by the seed.
struct HeldOut {
  std::string from;
  std::vector<Vector3> errors, uncorrected;
};

Expected<HeldOut> hold_out(const ArmArguments& options, const std::vector<ArmObservation>& samples,
                           const ArmModel& model, const ArmOptions& how, const ArmSolution& arm,
                           const ArmSolution& uncorrected) {
  HeldOut held;
  if (!options.test.empty()) {
    const auto test = read_arm_samples(options.test);
    if (!test) return tl::unexpected(test.error());
    for (const auto& sample : test->observations) {
      if (sample.joints.size() != model.joint_count())
        return wrong_use("{}: has {} joint columns, the arm {} has {} joints", options.test,
                         sample.joints.size(), model.name, model.joint_count());
      if (arm.tip_known && !sample.marker && !sample.tip)
        return wrong_use("{}: has no measured tips", options.test);
    }
    held.from = test->source;
    held.errors = arm_errors(arm, test->observations);
    held.uncorrected = arm_errors(uncorrected, test->observations);
    return held;
  }
  held.from = fmt::format("{} folds of the samples", kFolds);
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), 0u);
  Random random(options.seed, "calibrate arm/folds");
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<ArmObservation> training, test;
    for (std::size_t i = 0; i < order.size(); ++i)
      (static_cast<int>(i) % kFolds == fold ? test : training).push_back(samples[order[i]]);
    const auto estimate = calibrate_arm(training, model, how);
    if (!estimate) return tl::unexpected(estimate.error());
    const auto errors = arm_errors(estimate->value, test);
    held.errors.insert(held.errors.end(), errors.begin(), errors.end());
  }
  held.uncorrected = arm_errors(uncorrected, samples);
  return held;
}

double largest(const std::vector<Vector3>& errors) {
  double most = 0.0;
  for (const auto& e : errors) most = std::max(most, e.norm());
  return most;
}

// Units of each parameter in the files people read.
std::pair<std::string, double> with_unit(const std::string& name) {
  const auto starts = [&](const char* prefix) { return name.rfind(prefix, 0) == 0; };
  if (starts("gain_")) return {name, 1.0};
  if (starts("offset_") || starts("alpha_") || starts("base_rotation_"))
    return {name + "_deg", kDegreesPerRadian};
  return {name + "_mm", kMm};
}

// Standard deviations by group; 0 for what was held fixed.
Json std_json(const Estimate<ArmSolution>& estimate) {
  Json json = Json::object();
  const auto n = static_cast<std::size_t>(estimate.value.gain.size());
  const auto group = [&](const char* key, const std::vector<std::string>& names) {
    Json list = Json::array();
    bool any = false;
    for (const auto& name : names) {
      const auto at = std::find(estimate.value.parameters.begin(), estimate.value.parameters.end(), name);
      const bool found = at != estimate.value.parameters.end();
      any = any || found;
      list.push_back(found ? with_unit(name).second *
                                 estimate.standard_deviation(at - estimate.value.parameters.begin())
                           : 0.0);
    }
    if (any) json[key] = list;
  };
  const auto numbered = [&](const char* stem, std::size_t count) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < count; ++i) names.push_back(fmt::format("{}_{}", stem, i + 1));
    return names;
  };
  const auto axes = [](const std::string& stem) {
    return std::vector<std::string>{stem + "_x", stem + "_y", stem + "_z"};
  };
  group("gains", numbered("gain", n));
  group("offsets_deg", numbered("offset", n));
  group("lengths_mm", numbered("length", 2));
  group("a_mm", numbered("a", n));
  group("d_mm", numbered("d", n));
  group("alpha_deg", numbered("alpha", n));
  group("tool_mm", axes("tool"));
  group("tip_mm", axes("tip"));
  group("base_rotation_deg", axes("base_rotation"));
  group("base_translation_mm", axes("base_translation"));
  return json;
}

void put_arm(Json& json, const ArmSolution& arm) {
  json["gains"] = json_list(arm.gain);
  json["offsets_deg"] = json_list(arm.offset, kDegreesPerRadian);
  if (arm.model.kind == ArmModel::Kind::phantom) {
    json["lengths_mm"] = Json::array({kMm * arm.model.lengths.l1, kMm * arm.model.lengths.l2});
  } else {
    json["joints"] = Json::array();
    for (const auto& row : arm.model.joints)
      json["joints"].push_back(Json{{"a_mm", kMm * row.a},
                                    {"alpha_deg", degrees_from_radians(row.alpha)},
                                    {"d_mm", kMm * row.d},
                                    {"theta_offset_deg", degrees_from_radians(row.theta_offset)}});
    json["tool_mm"] = json_list(arm.model.tool, kMm);
  }
  json["tip_mm"] = arm.tip_known ? json_list(arm.tip_in_marker, kMm) : Json();
  json["base"] = Json{{"translation_mm", json_list(arm.X_world_base.translation, kMm)},
                      {"rotation_qwxyz", json_quaternion(arm.X_world_base.rotation)}};
}

void put_gimbal(Json& json, const Estimate<GimbalSolution>& gimbal, const std::vector<Vector3>& errors) {
  json["gimbal_gains"] = json_list(gimbal.value.correction.gain);
  json["gimbal_offsets_deg"] = json_list(gimbal.value.correction.offset, kDegreesPerRadian);
  json["marker_on_stylus_qwxyz"] = json_quaternion(gimbal.value.R_tip_marker);
  std::vector<Vector3> trained;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (gimbal.inlier[i]) trained.push_back(errors[i]);
  json["orientation_rms_deg"] = degrees_from_radians(rms_per_component(trained));
}

// The rig's order: gains, offsets, base rotation, base translation, tip; zero where fixed.
Eigen::MatrixXd rig_covariance(const Estimate<ArmSolution>& estimate) {
  std::vector<std::string> order{"gain_1", "gain_2", "gain_3", "offset_1", "offset_2", "offset_3"};
  for (const char* stem : {"base_rotation_", "base_translation_", "tip_"})
    for (const char axis : {'x', 'y', 'z'}) order.push_back(std::string(stem) + axis);
  const auto& names = estimate.value.parameters;
  const auto place = [&](std::size_t i) {
    return std::find(names.begin(), names.end(), order[i]) - names.begin();
  };
  const auto known = static_cast<std::ptrdiff_t>(names.size());
  const auto n = static_cast<Eigen::Index>(order.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto a = place(static_cast<std::size_t>(i)), b = place(static_cast<std::size_t>(j));
      if (a < known && b < known) C(i, j) = estimate.covariance(a, b);
    }
  return C;
}

void put_into(Rig& rig, const Estimate<ArmSolution>& estimate,
              const std::optional<Estimate<GimbalSolution>>& gimbal, double held_out_mean, Provenance from) {
  const ArmSolution& arm = estimate.value;
  ArmCalibration result = rig.arm.value_or(ArmCalibration{});  // keeps what is fitted beside the arm
  result.model = arm.model.name;
  result.lengths = arm.model.lengths;
  result.correction = {arm.gain, arm.offset};
  result.X_world_base = arm.X_world_base;
  result.tip_in_marker = arm.tip_in_marker;
  if (gimbal) put_gimbal_into(result, gimbal->value);
  result.covariance = rig_covariance(estimate);
  result.held_out_mean = held_out_mean;
  result.from = std::move(from);
  rig.arm = std::move(result);
}

Expected<void> run_arm(const ArmArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  if (options.arm.empty() && options.result.rig.empty())
    return wrong_use(
        "--arm is required (phantom-premium-1.5 or a file), or a rig file that knows the arm (--rig)");
  auto model = read_arm_model(options.arm.empty() ? ArmModel{}.name : options.arm);
  if (!model) return tl::unexpected(model.error());
  if (options.arm.empty()) model->lengths = rig->nominal_lengths;
  if (model->kind == ArmModel::Kind::dh && !(options.result.rig.empty() && options.result.out.empty()))
    return wrong_use("{}: a rig file holds arms of the PHANToM kind only; use --json", model->name);
  const auto file = read_arm_samples(options.samples);
  if (!file) return tl::unexpected(file.error());
  const auto& samples = file->observations;
  const bool markers =
      std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.marker.has_value(); });

  const bool has_gimbal =
      markers && model->kind == ArmModel::Kind::phantom &&
      std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.gimbal.has_value(); });
  bool wants_gimbal = has_gimbal;

  ArmOptions how;
  how.method = options.method == "one-pass"      ? ArmMethod::one_pass
               : options.method == "alternating" ? ArmMethod::alternating
               : options.method == "eq7"         ? ArmMethod::eq7
                                                 : ArmMethod::joint;
  if (!options.tip_mm.empty())
    how.tip = Vector3(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]) / kMm;
  if (!how.tip && rig->tip_pivot) how.tip = rig->tip_pivot->tip_in_marker;
  const bool joint = how.method == ArmMethod::joint;
  if (options.free.empty()) {
    how.free.lengths = model->kind == ArmModel::Kind::phantom;
    how.free.tip = markers && joint;
  } else if (options.free == "auto") {
    how.free.tip = markers && joint;
    const auto chosen = choose_free(samples, *model, how);
    if (!chosen) return refused("{}: {}", file->source, chosen.error().message);
    how.free = *chosen;
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

  const auto estimate = calibrate_arm(samples, *model, how);
  if (!estimate)
    return tl::unexpected(Error{estimate.error().kind, file->source + ": " + estimate.error().message});
  const ArmSolution& arm = estimate->value;
  std::optional<Estimate<GimbalSolution>> gimbal;
  if (wants_gimbal) {
    auto fitted = calibrate_gimbal(samples, arm);
    if (!fitted)
      return tl::unexpected(Error{fitted.error().kind, file->source + ": " + fitted.error().message});
    gimbal = std::move(*fitted);
  }
  const auto uncorrected = uncorrected_arm(samples, *model, how);
  if (!uncorrected) return tl::unexpected(uncorrected.error());
  const auto held = hold_out(options, samples, *model, how, arm, uncorrected->value);
  if (!held) return tl::unexpected(held.error());
  const auto regions = held_out_by_region(samples, *model, how);

  std::vector<Vector3> trained;
  for (std::size_t i = 0; i < estimate->residuals.size(); ++i)
    if (estimate->inlier.empty() || estimate->inlier[i]) trained.push_back(estimate->residuals[i]);
  Result result;
  Json& json = result.json;
  json["method"] = options.method;
  json["arm"] = model->name;
  json["free"] = free_text(how.free, gimbal.has_value());
  json["train_mean_mm"] = kMm * mean_norm(trained);
  json["test_mean_mm"] = kMm * mean_norm(held->errors);
  json["test_rms_mm"] = kMm * std::sqrt(3.0) * rms_per_component(held->errors);
  json["test_max_mm"] = kMm * largest(held->errors);
  json["uncorrected_test_mean_mm"] = kMm * mean_norm(held->uncorrected);
  json["test_from"] = held->from;
  put_arm(json, arm);
  if (gimbal) put_gimbal(json, *gimbal, gimbal_errors(samples, arm, gimbal->value));
  json["rms_mm"] = kMm * rms_per_component(trained);
  json["samples"] = samples.size();
  json["inliers"] = trained.size();
  json["unobservable"] = estimate->unobservable;
  json["held_out_by_region_mm"] = Json::array();
  if (regions)
    for (double mean : *regions) json["held_out_by_region_mm"].push_back(kMm * mean);
  json["delay_s"] = 0.0;
  json["condition"] = estimate->condition;
  json["iterations"] = estimate->iterations;
  json["converged"] = estimate->termination != Termination::iteration_limit;
  std::vector<std::string> names;
  Eigen::VectorXd scales(estimate->covariance.rows());
  for (const auto& parameter : arm.parameters) {
    const auto [name, scale] = with_unit(parameter);
    scales[static_cast<Eigen::Index>(names.size())] = scale;
    names.push_back(name);
  }
  json["std"] = std_json(*estimate);
  if (gimbal) {
    const Eigen::VectorXd deviations = gimbal->covariance.diagonal().cwiseSqrt();
    json["std"]["gimbal_gains"] = json_list(deviations.head<3>());
    json["std"]["gimbal_offsets_deg"] =
        json_list(Vector3(deviations[3], deviations[4], 0.0), kDegreesPerRadian);
    json["std"]["marker_on_stylus_deg"] = json_list(deviations.tail<3>(), kDegreesPerRadian);
    for (const auto& name : gimbal->unobservable) json["unobservable"].push_back(name);
  }
  json["covariance"] = json_covariance(names, estimate->covariance, scales);
  json["warnings"] = Json::array();
  if (!joint && how.free.tip)
    json["warnings"].push_back(
        fmt::format("method {} takes the tip as given; it was not estimated", options.method));
  if (!joint && arm.tip_known && !how.tip)
    json["warnings"].push_back("no tip was given (--tip-mm): it was found with the arm's nominal kinematics");
  if (estimate->termination == Termination::iteration_limit)
    json["warnings"].push_back("the solution had not settled at the iteration limit");
  json["data"] = Json{{"file", file->source}, {"hash", file->hash}};

  result.summary = {
      fmt::format("uncorrected  {:.4f} mm mean", json["uncorrected_test_mean_mm"].get<double>()),
      fmt::format("{:<11}  {:.4f} mm mean on unseen samples ({:.4f} on its own), largest {:.4f}; unseen: {}",
                  options.method, json["test_mean_mm"].get<double>(), json["train_mean_mm"].get<double>(),
                  json["test_max_mm"].get<double>(), held->from),
      fmt::format("gains        {}", shown(arm.gain)),
      fmt::format("offsets      {} deg", shown(arm.offset, kDegreesPerRadian))};
  if (arm.tip_known)
    result.summary.push_back(fmt::format("tip          {} mm in its marker", shown(arm.tip_in_marker, kMm)));
  if (gimbal) {
    result.summary.push_back(fmt::format(
        "gimbal       gains {}, offsets {} deg; {:.3f} deg rms to the marker",
        shown(gimbal->value.correction.gain), shown(gimbal->value.correction.offset, kDegreesPerRadian),
        json["orientation_rms_deg"].get<double>()));
  }
  std::string unseen;
  for (const auto& name : estimate->unobservable) unseen += (unseen.empty() ? "" : ", ") + name;
  if (!unseen.empty())
    result.summary.push_back("hardly seen by these data (kept near the nominal value by the prior): " +
                             unseen);
  for (const auto& warning : json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  result.store = [&](Rig& target) {
    put_into(target, *estimate, gimbal, mean_norm(held->errors),
             {utc_now(), file->hash, options.method, json["rms_mm"].get<double>()});
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
      ->add_option("--free", options->free, "What is estimated: gains,offsets,lengths,tip,gimbal,dh, or auto")
      ->type_name("LIST");
  command->add_option("--tip-mm", options->tip_mm, "The tip in its marker, from a pivot calibration")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command->add_option("--seed", options->seed, "Draws the folds")->capture_default_str();
  add_result_options(*command, options->result);
  on(command, [options] { return run_arm(*options); });
}

}  // namespace palpate::app
