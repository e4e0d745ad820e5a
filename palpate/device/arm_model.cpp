#include "palpate/device/arm_model.h"

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "palpate/core/file.h"
#include "palpate/core/toml.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_model_file.h"

namespace palpate::device {
namespace {

void check_joints(const ArmModel& model, const Eigen::VectorXd& theta) {
  if (theta.size() != model.joint_count())
    throw std::invalid_argument(fmt::format("arm model {}: {} joint angles given, {} expected", model.name,
                                            theta.size(), model.joint_count()));
}

Matrix3 rot_x(double angle) { return Eigen::AngleAxisd(angle, Vector3::UnitX()).toRotationMatrix(); }
Matrix3 rot_z(double angle) { return Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix(); }

}  // namespace

ReadingUnit reading_unit(const ArmModel& model) {
  if (model.kind == ArmModel::Kind::cartesian) return {"mm", kMillimetresPerMetre};
  return {"deg", kDegreesPerRadian};
}

Point<ArmBase> arm_tip(const ArmModel& model, const Eigen::VectorXd& theta) {
  check_joints(model, theta);
  if (model.kind == ArmModel::Kind::phantom) return phantom_tip(theta, model.lengths);
  if (model.kind == ArmModel::Kind::cartesian)
    return {theta.head<3>() + model.correction.at(Vector3(theta.head<3>()))};
  Vector3 point = model.tool;
  for (std::size_t j = model.joints.size(); j-- > 0;) {
    const DhJoint& row = model.joints[j];
    point = rot_z(theta[static_cast<Eigen::Index>(j)] + row.theta_offset) *
            (Vector3(row.a, 0.0, row.d) + rot_x(row.alpha) * point);
  }
  return {point};
}

Point<ArmBase> arm_tip(const ArmModel& model, const Eigen::VectorXd& theta, ArmJacobian& jacobian) {
  check_joints(model, theta);
  if (model.kind == ArmModel::Kind::phantom) {
    // As phantom_tip and phantom_jacobian have it, with each sine taken once: solvers live here.
    const auto [l1, l2] = model.lengths;
    const double s1 = std::sin(theta[0]), c1 = std::cos(theta[0]), s2 = std::sin(theta[1]),
                 c2 = std::cos(theta[1]), s3 = std::sin(theta[2]), c3 = std::cos(theta[2]);
    const double reach = l1 * c2 + l2 * s3;
    jacobian.theta.resize(3, 3);
    jacobian.theta << c1 * reach, -s1 * l1 * s2, s1 * l2 * c3,  //
        0.0, l1 * c2, l2 * s3,                                  //
        -s1 * reach, -c1 * l1 * s2, c1 * l2 * c3;
    jacobian.lengths << s1 * c2, s1 * s3, s2, 1.0 - c3, -1.0 + c1 * c2, c1 * s3;
    return {Vector3(s1 * reach, l2 - l2 * c3 + l1 * s2, -l1 + c1 * reach)};
  }
  if (model.kind == ArmModel::Kind::cartesian) {
    const Vector3 stated = theta.head<3>();
    jacobian.theta = Matrix3::Identity() + model.correction.slope(stated);
    jacobian.correction = model.correction.basis(stated);
    return {stated + jacobian.correction * model.correction.terms};
  }
  const auto n = static_cast<Eigen::Index>(model.joints.size());
  jacobian.theta.resize(3, n);
  jacobian.a.resize(3, n);
  jacobian.alpha.resize(3, n);
  jacobian.d.resize(3, n);
  // behind[j]: the tip as frame j sees it (frame n is the last link's)
  std::vector<Vector3> behind(model.joints.size() + 1);
  behind.back() = model.tool;
  for (Eigen::Index j = n; j-- > 0;) {
    const DhJoint& row = model.joints[static_cast<std::size_t>(j)];
    behind[static_cast<std::size_t>(j)] =
        rot_z(theta[j] + row.theta_offset) *
        (Vector3(row.a, 0.0, row.d) + rot_x(row.alpha) * behind[static_cast<std::size_t>(j) + 1]);
  }
  Matrix3 R = Matrix3::Identity();  // axes of frame j in ArmBase
  for (Eigen::Index j = 0; j < n; ++j) {
    const DhJoint& row = model.joints[static_cast<std::size_t>(j)];
    const Matrix3 turned = R * rot_z(theta[j] + row.theta_offset);
    const Vector3 tilted = rot_x(row.alpha) * behind[static_cast<std::size_t>(j) + 1];
    jacobian.theta.col(j) = R * Vector3::UnitZ().cross(behind[static_cast<std::size_t>(j)]);
    jacobian.a.col(j) = turned.col(0);
    jacobian.alpha.col(j) = turned * Vector3::UnitX().cross(tilted);
    jacobian.d.col(j) = R.col(2);
    R = turned * rot_x(row.alpha);
  }
  jacobian.tool = R;
  return {behind.front()};
}

ArmModel laboratory_delta() {
  ArmModel model;
  model.kind = ArmModel::Kind::cartesian;
  model.name = kLaboratoryDelta;
  model.places = {{{-0.3, 0.3}, {-0.15, 0.35}, {-0.3, 0.3}}};
  model.correction.centre = {0.0, 0.1, 0.0};
  model.correction.reach = 0.3;
  return model;
}

Expected<ArmModel> read_arm_model(const std::string& name_or_file) {
  if (name_or_file == ArmModel{}.name) return ArmModel{};
  if (name_or_file == kLaboratoryDelta) return laboratory_delta();
  if (!is_there(name_or_file))
    return wrong_use(
        "arm model {}: neither a known arm (phantom-premium-1.5, laboratory-delta) nor a file; check the "
        "path",
        name_or_file);
  const auto content = read_file(name_or_file, kMostSettingsBytes);
  if (!content) return tl::unexpected(content.error());
  return parse_arm_model(*content, name_or_file);
}

Expected<ArmModel> parse_arm_model(std::string_view content, std::string source) {
  const auto file = parse_toml(content, source);
  if (!file) return tl::unexpected(file.error());
  ArmModel model;
  model.name = file->text_or("name", std::filesystem::path(source).stem().string());
  const auto type = file->choice("type", {"dh", "phantom", "cartesian"});
  if (type == "phantom") {
    const auto lengths = file->numbers<2>("lengths_mm", kPositive);
    model.lengths = {metres_from_mm(lengths[0]), metres_from_mm(lengths[1])};
  } else if (type == "cartesian") {
    read_cartesian(*file, model);
  } else {
    read_dh_chain(*file, model);
  }
  if (const auto done = file->finish(); !done) return tl::unexpected(done.error());
  return model;
}

}  // namespace palpate::device
