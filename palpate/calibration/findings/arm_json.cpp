#include "palpate/calibration/findings/arm_json.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/arm_motion.h"
#include "palpate/calibration/arm_prediction.h"

namespace palpate::calibration::findings {
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
  group("quadratic_per_rad", numbered("quadratic", n));
  group("hysteresis_deg", numbered("hysteresis", n));
  group("lengths_mm", numbered("length", 2));
  group("a_mm", numbered("a", n));
  group("d_mm", numbered("d", n));
  group("alpha_deg", numbered("alpha", n));
  group("tool_mm", axes("tool"));
  const auto& terms = device::PlaceCorrection::names();
  group("correction_mm", {terms.begin(), terms.end()});
  group("tip_mm", axes("tip"));
  group("base_rotation_deg", axes("base_rotation"));
  group("base_translation_mm", axes("base_translation"));
  return json;
}

void put_arm(Json& json, const ArmSolution& arm) {
  const bool cartesian = arm.model.kind == device::ArmModel::Kind::cartesian;
  if (!cartesian) {
    json["gains"] = json_list(arm.gain);
    json["offsets_deg"] = json_list(arm.offset, kDegreesPerRadian);
  }
  if (arm.quadratic.size() > 0) json["quadratic_per_rad"] = json_list(arm.quadratic);
  if (arm.hysteresis.size() > 0) json["hysteresis_deg"] = json_list(arm.hysteresis, kDegreesPerRadian);
  json["delay_s"] = arm.delay_s;
  if (arm.model.kind == device::ArmModel::Kind::phantom) {
    json["lengths_mm"] = Json::array({kMm * arm.model.lengths.l1, kMm * arm.model.lengths.l2});
  } else if (cartesian) {
    json["correction_mm"] = json_list(arm.model.correction.terms, kMm);
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

// By how much the places that a Cartesian arm stated are corrected.
void put_correction(Json& json, const ArmSolution& arm, const std::vector<device::ArmObservation>& samples) {
  double square = 0.0, most = 0.0;
  for (const auto& sample : samples) {
    const double size = arm.model.correction.at(Vector3(sample.joints.head<3>())).norm();
    square += size * size / static_cast<double>(samples.size());
    most = std::max(most, size);
  }
  json["correction_rms_mm"] = kMm * std::sqrt(square);
  json["correction_max_mm"] = kMm * most;
}

void put_gimbal(Json& json, const Estimate<GimbalSolution>& gimbal) {
  json["gimbal_gains"] = json_list(gimbal.value.correction.gain);
  json["gimbal_offsets_deg"] = json_list(gimbal.value.correction.offset, kDegreesPerRadian);
  json["marker_on_stylus_qwxyz"] = json_quaternion(gimbal.value.R_tip_marker);
}

// Samples that the others contradict, by their lines where they are a file's.
void put_left_out(Json& json, const ArmFindings& found) {
  const auto& inlier = found.estimate.inlier;
  const auto& samples = found.samples.observations;
  if (std::find(inlier.begin(), inlier.end(), false) == inlier.end()) return;
  if (!found.unseen_of_fitting.empty())
    json["test_mean_of_fitting_mm"] = kMm * mean_norm(found.unseen_of_fitting);
  json["left_out_lines"] = Json::array();
  for (std::size_t i = 0; i < samples.size() && i < inlier.size(); ++i)
    if (!inlier[i] && samples[i].line > 0) json["left_out_lines"].push_back(samples[i].line);
}

// Where the calibration is good, and where it is not.
void put_map(Json& json, const PredictedErrorMap& map) {
  Json places = Json::array();
  for (const auto& place : map.places)
    places.push_back(Json{{"tip_mm", json_list(place.tip.m, kMm)}, {"sd_mm", kMm * place.sd}});
  json["predicted_error"] = Json{{"rms_mm", kMm * map.rms},
                                 {"worst_mm", kMm * map.worst.sd},
                                 {"worst_tip_mm", json_list(map.worst.tip.m, kMm)},
                                 {"map", places}};
}

}  // namespace

double gimbal_rms_deg(const Estimate<GimbalSolution>& gimbal, const ArmSolution& arm,
                      const std::vector<device::ArmObservation>& samples) {
  const auto errors = gimbal_errors(with_delay_removed(samples, arm.delay_s), arm, gimbal.value);
  std::vector<Vector3> trained;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (gimbal.inlier[i]) trained.push_back(errors[i]);
  return degrees_from_radians(rms_per_component(trained));
}

Json arm_json(const ArmFindings& found) {
  const ArmSolution& arm = found.estimate.value;
  const auto& estimate = found.estimate;
  const auto& gimbal = found.gimbal;
  std::vector<Vector3> trained;
  for (std::size_t i = 0; i < estimate.residuals.size(); ++i)
    if (estimate.inlier.empty() || estimate.inlier[i]) trained.push_back(estimate.residuals[i]);
  Json json;
  json["method"] = name_of(found.method);
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
  if (arm.model.kind == device::ArmModel::Kind::cartesian) put_correction(json, arm, observations);
  if (gimbal) {
    put_gimbal(json, *gimbal);
    json["orientation_rms_deg"] = gimbal_rms_deg(*gimbal, arm, observations);
  }
  json["rms_mm"] = kMm * rms_per_component(trained);
  json["samples"] = observations.size();
  json["inliers"] = trained.size();
  put_left_out(json, found);
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
  if (found.method == ArmMethod::joint) {
    json["noise"] = Json{{"sigma_mm", kMm * arm.noise.sigma},
                         {"systematic_share", arm.noise.field_share},
                         {"systematic_reach_mm", kMm * arm.noise.field_reach}};
    put_map(json, predicted_error_map(estimate, observations));
  }
  json["warnings"] = found.warnings;
  return json;
}

}  // namespace palpate::calibration::findings
