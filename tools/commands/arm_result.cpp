#include "tools/commands/arm_result.h"

#include <algorithm>

#include "palpate/calibration/arm_motion.h"
#include "palpate/calibration/arm_prediction.h"
#include "palpate/core/units.h"

namespace palpate::tools::commands {
namespace {

double largest(const std::vector<Vector3>& errors) {
  double most = 0.0;
  for (const auto& e : errors) most = std::max(most, e.norm());
  return most;
}

// Units of each parameter in the files people read.
std::pair<std::string, double> with_unit(const std::string& name) {
  const auto starts = [&](const char* prefix) { return name.rfind(prefix, 0) == 0; };
  if (starts("gain_")) return {name, 1.0};
  if (starts("quadratic_")) return {name + "_per_rad", 1.0};
  if (name == "delay") return {"delay_s", 1.0};
  if (starts("offset_") || starts("alpha_") || starts("hysteresis_") || starts("base_rotation_"))
    return {name + "_deg", kDegreesPerRadian};
  return {name + "_mm", kMm};
}

// Standard deviations by group; 0 for what was held fixed.
Json std_json(const Estimate<calibration::ArmSolution>& estimate) {
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
  group("quadratic_per_rad", numbered("quadratic", n));
  group("hysteresis_deg", numbered("hysteresis", n));
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

void put_arm(Json& json, const calibration::ArmSolution& arm) {
  json["gains"] = json_list(arm.gain);
  json["offsets_deg"] = json_list(arm.offset, kDegreesPerRadian);
  if (arm.quadratic.size() > 0) json["quadratic_per_rad"] = json_list(arm.quadratic);
  if (arm.hysteresis.size() > 0) json["hysteresis_deg"] = json_list(arm.hysteresis, kDegreesPerRadian);
  json["delay_s"] = arm.delay_s;
  if (arm.model.kind == device::ArmModel::Kind::phantom) {
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

void put_gimbal(Json& json, const Estimate<calibration::GimbalSolution>& gimbal,
                const std::vector<Vector3>& errors) {
  json["gimbal_gains"] = json_list(gimbal.value.correction.gain);
  json["gimbal_offsets_deg"] = json_list(gimbal.value.correction.offset, kDegreesPerRadian);
  json["marker_on_stylus_qwxyz"] = json_quaternion(gimbal.value.R_tip_marker);
  std::vector<Vector3> trained;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (gimbal.inlier[i]) trained.push_back(errors[i]);
  json["orientation_rms_deg"] = degrees_from_radians(rms_per_component(trained));
}

// Where the calibration is good, and where it is not.
void put_map(Json& json, const calibration::PredictedErrorMap& map) {
  Json places = Json::array();
  for (const auto& place : map.places)
    places.push_back(Json{{"tip_mm", json_list(place.tip.m, kMm)}, {"sd_mm", kMm * place.sd}});
  json["predicted_error"] = Json{{"rms_mm", kMm * map.rms},
                                 {"worst_mm", kMm * map.worst.sd},
                                 {"worst_tip_mm", json_list(map.worst.tip.m, kMm)},
                                 {"map", places}};
}

// In the rig's order, zero where fixed.
Eigen::MatrixXd rig_covariance(const Estimate<calibration::ArmSolution>& estimate) {
  const std::vector<std::string> order = rig::covariance_order(estimate.value.model);
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

}  // namespace

void put_into(rig::Rig& rig, const ArmFindings& found, rig::Provenance from) {
  const calibration::ArmSolution& arm = found.estimate.value;
  const bool chain = arm.model.kind == device::ArmModel::Kind::dh;
  const bool same_arm = rig.arm && rig.arm->model.kind == arm.model.kind &&
                        rig.arm->model.joint_count() == arm.model.joint_count();
  rig::ArmCalibration result = same_arm ? *rig.arm : rig::ArmCalibration{};
  if (!same_arm) result.rest_readings = device::JointVector::filled(arm.model.joint_count(), 0.0);
  if (chain || rig.nominal_arm.kind != arm.model.kind) rig.nominal_arm = found.nominal;
  result.model = arm.model;
  result.correction = {arm.gain, arm.offset};
  result.X_world_base = arm.X_world_base;
  result.tip_in_marker = arm.tip_in_marker;
  if (found.gimbal) calibration::put_gimbal_into(result, found.gimbal->value);
  result.covariance = rig_covariance(found.estimate);
  result.held_out_mean = mean_norm(found.unseen);
  const auto delay = std::find(arm.parameters.begin(), arm.parameters.end(), "delay");
  if (delay != arm.parameters.end()) {
    if (!rig.delays) rig.delays.emplace();
    rig.delays->tracker_after_arm_s = arm.delay_s;
    rig.delays->tracker_std_s = found.estimate.standard_deviation(delay - arm.parameters.begin());
    rig.delays->from = from;
  }
  result.from = std::move(from);
  rig.arm = std::move(result);
}

Json arm_json(const ArmFindings& found) {
  const calibration::ArmSolution& arm = found.estimate.value;
  const auto& estimate = found.estimate;
  const auto& gimbal = found.gimbal;
  std::vector<Vector3> trained;
  for (std::size_t i = 0; i < estimate.residuals.size(); ++i)
    if (estimate.inlier.empty() || estimate.inlier[i]) trained.push_back(estimate.residuals[i]);
  Json json;
  json["method"] = found.method;
  json["arm"] = arm.model.name;
  json["free"] = found.free;
  if (found.choice) {
    json["free_why"] = found.choice->why;
    json["free_tried"] = Json::array();
    for (const auto& [free, error] : found.choice->tried)
      json["free_tried"].push_back(Json{{"free", free}, {"unseen_region_mean_mm", kMm * error}});
  }
  json["train_mean_mm"] = kMm * mean_norm(trained);
  json["test_mean_mm"] = kMm * mean_norm(found.unseen);
  json["test_rms_mm"] = kMm * std::sqrt(3.0) * rms_per_component(found.unseen);
  json["test_max_mm"] = kMm * largest(found.unseen);
  json["uncorrected_test_mean_mm"] = kMm * mean_norm(found.unseen_uncorrected);
  json["test_from"] = found.unseen_from;
  put_arm(json, arm);
  const auto& observations = found.samples.observations;
  if (gimbal)
    put_gimbal(json, *gimbal,
               calibration::gimbal_errors(calibration::with_delay_removed(observations, arm.delay_s), arm,
                                          gimbal->value));
  json["rms_mm"] = kMm * rms_per_component(trained);
  json["samples"] = observations.size();
  json["inliers"] = trained.size();
  json["unobservable"] = estimate.unobservable;
  json["held_out_by_region_mm"] = Json::array();
  for (double mean : found.regions) json["held_out_by_region_mm"].push_back(kMm * mean);
  json["condition"] = estimate.condition;
  json["iterations"] = estimate.iterations;
  json["converged"] = estimate.termination != Termination::iteration_limit;
  std::vector<std::string> names;
  Eigen::VectorXd scales(estimate.covariance.rows());
  for (const auto& parameter : arm.parameters) {
    const auto [name, scale] = with_unit(parameter);
    scales[static_cast<Eigen::Index>(names.size())] = scale;
    names.push_back(name);
  }
  json["std"] = std_json(estimate);
  const auto delay = std::find(arm.parameters.begin(), arm.parameters.end(), "delay");
  if (delay != arm.parameters.end())
    json["delay_std_s"] = estimate.standard_deviation(delay - arm.parameters.begin());
  if (gimbal) {
    const Eigen::VectorXd deviations = gimbal->covariance.diagonal().cwiseSqrt();
    json["std"]["gimbal_gains"] = json_list(deviations.head<3>());
    json["std"]["gimbal_offsets_deg"] = json_list(deviations.segment<3>(3), kDegreesPerRadian);
    json["std"]["marker_on_stylus_deg"] = json_list(deviations.tail<3>(), kDegreesPerRadian);
    for (const auto& name : gimbal->unobservable) json["unobservable"].push_back(name);
  }
  json["covariance"] = json_covariance(names, estimate.covariance, scales);
  if (found.method == "joint") {
    json["noise"] = Json{{"sigma_mm", kMm * arm.noise.sigma},
                         {"systematic_share", arm.noise.field_share},
                         {"systematic_reach_mm", kMm * arm.noise.field_reach}};
    put_map(json, calibration::predicted_error_map(estimate, observations));
  }
  json["warnings"] = found.warnings;
  json["data"] = Json{{"file", found.samples.source}, {"hash", found.samples.hash}};
  return json;
}

std::vector<std::string> arm_summary(const ArmFindings& found, const Json& json) {
  const calibration::ArmSolution& arm = found.estimate.value;
  std::vector<std::string> lines = {
      fmt::format("uncorrected  {:.4f} mm mean", json["uncorrected_test_mean_mm"].get<double>()),
      fmt::format("{:<11}  {:.4f} mm mean on unseen samples ({:.4f} on its own), largest {:.4f}; unseen: {}",
                  found.method, json["test_mean_mm"].get<double>(), json["train_mean_mm"].get<double>(),
                  json["test_max_mm"].get<double>(), found.unseen_from),
      fmt::format("gains        {}", shown(arm.gain)),
      fmt::format("offsets      {} deg", shown(arm.offset, kDegreesPerRadian))};
  if (arm.tip_known)
    lines.push_back(fmt::format("tip          {} mm in its marker", shown(arm.tip_in_marker, kMm)));
  if (found.gimbal) {
    lines.push_back(fmt::format("gimbal       gains {}, offsets {} deg; {:.3f} deg rms to the marker",
                                shown(found.gimbal->value.correction.gain),
                                shown(found.gimbal->value.correction.offset, kDegreesPerRadian),
                                json["orientation_rms_deg"].get<double>()));
  }
  const auto all = found.estimate.residuals.size(), fitting = json["inliers"].get<std::size_t>();
  if (fitting < all)
    lines.push_back(
        fmt::format("left out     {} of {} samples, which do not fit the others", all - fitting, all));
  if (found.choice) lines.push_back("free         " + found.choice->why);
  if (json.contains("delay_std_s"))
    lines.push_back(fmt::format("delay        {:.2f} +- {:.2f} ms, tracker behind encoders",
                                1e3 * arm.delay_s, 1e3 * json["delay_std_s"].get<double>()));
  if (json.contains("predicted_error"))
    lines.push_back(fmt::format(
        "predicted    {:.3f} mm rms over the workspace, {:.3f} at worst, near {} mm",
        json["predicted_error"]["rms_mm"].get<double>(), json["predicted_error"]["worst_mm"].get<double>(),
        shown(Vector3(json["predicted_error"]["worst_tip_mm"][0], json["predicted_error"]["worst_tip_mm"][1],
                      json["predicted_error"]["worst_tip_mm"][2]))));
  std::string unseen;
  for (const auto& name : found.estimate.unobservable) unseen += (unseen.empty() ? "" : ", ") + name;
  if (!unseen.empty())
    lines.push_back("hardly seen by these data, mean nothing by themselves (held by the prior alone): " +
                    unseen);
  for (const auto& warning : found.warnings) lines.push_back("warning: " + warning);
  return lines;
}

}  // namespace palpate::tools::commands
