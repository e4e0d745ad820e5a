#include "palpate/calibration/internal/arm_parameters.h"

namespace palpate::calibration {
namespace {

using Part = ArmParameter::Part;

}  // namespace

double& number_of(ArmSolution& arm, const ArmParameter& parameter) {
  const auto i = parameter.index;
  const auto row = static_cast<std::size_t>(i);
  switch (parameter.part) {
    case Part::gain:
      return arm.gain[i];
    case Part::offset:
      return arm.offset[i];
    case Part::quadratic:
      return arm.quadratic[i];
    case Part::hysteresis:
      return arm.hysteresis[i];
    case Part::delay:
      return arm.delay_s;
    case Part::length:
      return i == 0 ? arm.model.lengths.l1 : arm.model.lengths.l2;
    case Part::a:
      return arm.model.joints[row].a;
    case Part::d:
      return arm.model.joints[row].d;
    case Part::alpha:
      return arm.model.joints[row].alpha;
    case Part::tool:
      return arm.model.tool[i];
    case Part::tip:
      return arm.tip_in_marker[i];
    case Part::correction:
      return arm.model.correction.terms[i];
    default:
      return arm.X_world_base.translation[i];
  }
}

double number_of(const ArmSolution& arm, const ArmParameter& parameter) {
  return number_of(const_cast<ArmSolution&>(arm), parameter);  // only read
}

std::vector<ArmParameter> list_parameters(const device::ArmModel& model, const ArmFreedom& freedom) {
  std::vector<ArmParameter> list;
  const auto joints = model.joint_count();
  const auto per_joint = [&](Part part, const char* name, double size) {
    for (Eigen::Index j = 0; j < joints; ++j)
      if (part != Part::offset || j > 0 || freedom.first_offset)
        list.push_back({part, j, fmt::format("{}_{}", name, j + 1), size});
  };
  const auto per_axis = [&](Part part, const char* name, double size) {
    for (Eigen::Index i = 0; i < 3; ++i)
      list.push_back({part, i, fmt::format("{}_{}", name, "xyz"[i]), size});
  };
  const bool dh = model.kind == device::ArmModel::Kind::dh,
             cartesian = model.kind == device::ArmModel::Kind::cartesian;
  if (freedom.base) {
    per_axis(Part::base_rotation, "base_rotation", 1.0);
    per_axis(Part::base_translation, "base_translation", 1.0);
  }
  if (freedom.gains) per_joint(Part::gain, "gain", 0.1);
  if (freedom.offsets) per_joint(Part::offset, "offset", 1.0);
  if (freedom.quadratic) per_joint(Part::quadratic, "quadratic", 0.1);
  if (freedom.hysteresis) per_joint(Part::hysteresis, "hysteresis", 0.02);
  if (freedom.delay) list.push_back({Part::delay, 0, "delay", 0.2});
  if (freedom.lengths && !dh && !cartesian) {
    list.push_back({Part::length, 0, "length_1", 0.02});
    list.push_back({Part::length, 1, "length_2", 0.02});
  }
  if (freedom.lengths && dh) {
    per_joint(Part::a, "a", 0.02);
    per_joint(Part::d, "d", 0.02);
  }
  if (freedom.alpha) per_joint(Part::alpha, "alpha", 0.175);
  if (freedom.tool) per_axis(Part::tool, "tool", 0.5);
  if (freedom.tip) per_axis(Part::tip, "tip", 0.1);
  if (freedom.correction && cartesian)
    for (Eigen::Index k = 0; k < device::PlaceCorrection::kTerms; ++k)
      list.push_back(
          {Part::correction, k, device::PlaceCorrection::names()[static_cast<std::size_t>(k)], 0.005});
  return list;
}

std::vector<ArmParameter> parameters_named(const device::ArmModel& model,
                                           const std::vector<std::string>& names) {
  const auto all = list_parameters(model, {.base = true,
                                           .gains = true,
                                           .offsets = true,
                                           .first_offset = true,
                                           .quadratic = true,
                                           .hysteresis = true,
                                           .delay = true,
                                           .lengths = true,
                                           .alpha = true,
                                           .tool = model.kind == device::ArmModel::Kind::dh,
                                           .tip = true,
                                           .correction = true});
  std::vector<ArmParameter> list;
  for (const auto& name : names)
    for (const auto& parameter : all)
      if (parameter.name == name) list.push_back(parameter);
  return list;
}

Vector3 rotation_part(const std::vector<ArmParameter>& parameters, const Eigen::VectorXd& x) {
  Vector3 w = Vector3::Zero();
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].part == Part::base_rotation) w[parameters[k].index] = x[static_cast<Eigen::Index>(k)];
  return w;
}

ArmSolution moved(const ArmSolution& at, const std::vector<ArmParameter>& parameters,
                  const Eigen::VectorXd& x) {
  ArmSolution result = at;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].part != Part::base_rotation)
      number_of(result, parameters[k]) += x[static_cast<Eigen::Index>(k)];
  result.X_world_base.rotation =
      (so3_exp(rotation_part(parameters, x)) * at.X_world_base.rotation).normalized();
  return result;
}

}  // namespace palpate::calibration
