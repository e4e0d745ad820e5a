#include "tools/commands/arm_result.h"

#include <algorithm>

#include "palpate/calibration/session/arm_observations.h"
#include "palpate/core/units.h"

namespace palpate::tools::commands {
namespace {

// "  +- 0.0002 0.0003 0.0003" of what the solve estimated; nothing where it was given or a deviation is not stated.
std::string deviations_of(const char* key, const Json& json) {
  const Json all = json.value("std", Json::object());
  if (!all.contains(key)) return "";
  const auto sd = all[key].get<std::vector<double>>();
  return "  +- " + shown(Eigen::Map<const Eigen::VectorXd>(sd.data(), static_cast<Eigen::Index>(sd.size())));
}

// Which samples the fit went without, and what those that it went by are predicted to.
std::string left_out_text(const Json& json, std::size_t left_out, std::size_t all) {
  constexpr std::size_t kMostLines = 8;
  std::string lines;
  const Json at = json.value("left_out_lines", Json::array());
  for (std::size_t i = 0; i < std::min(at.size(), kMostLines); ++i)
    lines += fmt::format("{}{}", i == 0 ? (at.size() == 1 ? " (line " : " (lines ") : ", ", at[i].get<int>());
  if (!lines.empty()) lines += at.size() > kMostLines ? ", ...)" : ")";
  std::string text =
      fmt::format("left out     {} of {} samples, which do not fit the others{}", left_out, all, lines);
  if (json.contains("test_mean_of_fitting_mm"))
    text += fmt::format("; without them {:.4f} mm on samples not seen",
                        json["test_mean_of_fitting_mm"].get<double>());
  return text;
}

}  // namespace

void put_into(rig::Rig& rig, const calibration::findings::ArmFindings& found, rig::Provenance from) {
  const calibration::ArmSolution& arm = found.estimate.value;
  const bool phantom = arm.model.kind == device::ArmModel::Kind::phantom;
  const bool same_arm = rig.arm && rig.arm->model.kind == arm.model.kind &&
                        rig.arm->model.joint_count() == arm.model.joint_count();
  rig::ArmCalibration result = same_arm ? *rig.arm : rig::ArmCalibration{};
  if (!same_arm) {  // no table tells what it reads at rest
    result.rest_readings = device::JointVector::filled(arm.model.joint_count(), 0.0);
    result.rest_known = false;
  }
  if (!phantom || rig.nominal_arm.kind != arm.model.kind) rig.nominal_arm = found.nominal;
  result.model = arm.model;
  result.correction = {arm.gain, arm.offset};
  result.X_world_base = arm.X_world_base;
  result.tip_in_marker = arm.tip_in_marker;
  if (found.gimbal) calibration::put_gimbal_into(result, found.gimbal->value);
  result.covariance = calibration::session::rig_covariance(found.estimate);
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

Expected<device::JointVector> rest_readings_of(const std::vector<double>& given,
                                               const device::ArmModel& model) {
  if (static_cast<Eigen::Index>(given.size()) != model.joint_count())
    return wrong_use("--rest-readings: {} readings are given, the arm {} has {} joints", given.size(),
                     model.name, model.joint_count());
  device::JointVector readings = device::JointVector::filled(model.joint_count(), 0.0);
  for (std::size_t j = 0; j < given.size(); ++j)
    readings[static_cast<Eigen::Index>(j)] = given[j] / device::reading_unit(model).per_si;
  return readings;
}

std::vector<std::string> arm_summary(const calibration::findings::ArmFindings& found) {
  const Json& json = found.json;
  const calibration::ArmSolution& arm = found.estimate.value;
  std::vector<std::string> lines = {
      fmt::format("uncorrected  mean error {:.4f} mm, the arm as its maker describes it",
                  json["uncorrected_test_mean_mm"].get<double>()),
      fmt::format("{:<11}  mean error {:.4f} mm, largest {:.4f}, on samples that it has not seen ({}); "
                  "{:.4f} on those that it was fitted to",
                  calibration::findings::name_of(found.method), json["test_mean_mm"].get<double>(),
                  json["test_max_mm"].get<double>(), found.unseen_from, json["train_mean_mm"].get<double>())};
  if (arm.model.kind == device::ArmModel::Kind::cartesian) {
    lines.push_back(fmt::format("correction   {:.3f} mm rms over the samples, {:.3f} at most",
                                json["correction_rms_mm"].get<double>(),
                                json["correction_max_mm"].get<double>()));
  } else {
    lines.push_back(fmt::format("gains        {}{}", shown(arm.gain), deviations_of("gains", json)));
    lines.push_back(fmt::format("offsets      {} deg{}", shown(arm.offset, kDegreesPerRadian),
                                deviations_of("offsets_deg", json)));
  }
  if (arm.tip_known)
    lines.push_back(fmt::format("tip          {} mm in its marker{}", shown(arm.tip_in_marker, kMm),
                                deviations_of("tip_mm", json)));
  if (found.gimbal) {
    lines.push_back(fmt::format("gimbal       gains {}, offsets {} deg; {:.3f} deg rms to the marker",
                                shown(found.gimbal->value.correction.gain),
                                shown(found.gimbal->value.correction.offset, kDegreesPerRadian),
                                json["orientation_rms_deg"].get<double>()));
  }
  const auto all = found.estimate.residuals.size(), fitting = json["inliers"].get<std::size_t>();
  if (fitting < all) lines.push_back(left_out_text(json, all - fitting, all));
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
