// What can be asked of a rig.
#include <fmt/format.h>

#include <ctime>

#include "palpate/core/units.h"
#include "palpate/rig/rig.h"

namespace palpate::rig {

Point<World> SurfaceCalibration::corner(int i) const {
  const Vector3 at((i == 1 || i == 2) ? width : 0.0, i >= 2 ? height : 0.0, 0.0);
  return X_world_rectangle * Point<Rectangle>{at};
}

const SurfaceCalibration* Rig::surface(std::string_view surface_name) const {
  for (const auto& s : surfaces)
    if (s.name == surface_name) return &s;
  return nullptr;
}

bool has_two_eyes(const Rig& rig) {
  return rig.camera && rig.hand_eye && rig.right_camera && rig.right_hand_eye;
}

Pose<CameraOptical, RightCamera> right_in_left(const Rig& rig) {
  const auto X = rig.hand_eye->X_marker_camera.inverse() * rig.right_hand_eye->X_marker_camera;
  return {X.rotation, X.translation};
}

Pose<World, CameraOptical> right_eye_pose(const Rig& rig, const Pose<World, CameraOptical>& X_world_left) {
  const auto X = X_world_left * right_in_left(rig);
  return {X.rotation, X.translation};
}

Rig right_eye_rig(const Rig& rig) {
  Rig right = rig;
  right.camera = rig.right_camera;
  right.hand_eye = rig.right_hand_eye;
  right.registration_covariance = rig.right_registration_covariance;
  right.right_camera.reset(), right.right_hand_eye.reset();
  right.right_registration_covariance.resize(0, 0);
  return right;
}

std::vector<std::string> covariance_order(const device::ArmModel& model) {
  std::vector<std::string> order;
  for (const char* stem : {"gain_", "offset_"})
    for (Eigen::Index j = 1; j <= model.joint_count(); ++j) order.push_back(stem + std::to_string(j));
  const auto axes = [&](const std::string& stem) {
    for (const char axis : {'x', 'y', 'z'}) order.push_back(stem + axis);
  };
  axes("base_rotation_");
  axes("base_translation_");
  axes("tip_");
  if (model.kind == device::ArmModel::Kind::dh) axes("tool_");
  if (model.kind == device::ArmModel::Kind::cartesian)
    for (const auto& name : device::PlaceCorrection::names()) order.push_back(name);
  return order;
}

device::JointVector rest_change(const ArmCalibration& arm, const device::JointVector& rest_readings) {
  return rest_readings - arm.rest_readings;
}

ModelNumbers numbers_of(const device::ArmModel& model) {
  ModelNumbers numbers;
  if (model.kind == device::ArmModel::Kind::phantom) {
    numbers.lengths = Eigen::Vector2d(model.lengths.l1, model.lengths.l2);
    return numbers;
  }
  if (model.kind == device::ArmModel::Kind::cartesian) {
    numbers.lengths.resize(6 + device::PlaceCorrection::kTerms);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto& [low, high] = model.places[static_cast<std::size_t>(i)];
      numbers.lengths.segment<2>(2 * i) << low, high;
    }
    numbers.lengths.tail<device::PlaceCorrection::kTerms>() = model.correction.terms;
    return numbers;
  }
  const auto n = static_cast<Eigen::Index>(model.joints.size());
  numbers.lengths.resize(2 * n + 3);
  numbers.angles.resize(2 * n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const device::DhJoint& joint = model.joints[static_cast<std::size_t>(j)];
    numbers.lengths.segment<2>(2 * j) << joint.a, joint.d;
    numbers.angles.segment<2>(2 * j) << joint.alpha, joint.theta_offset;
  }
  numbers.lengths.tail<3>() = model.tool;
  return numbers;
}

namespace {

bool same_within(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double tolerance) {
  return a.size() == b.size() && (a.size() == 0 || (a - b).cwiseAbs().maxCoeff() <= tolerance);
}

bool same(const ModelNumbers& now, const ModelNumbers& then) {
  return same_within(now.lengths, then.lengths, kLengthTolerance) &&
         same_within(now.angles, then.angles, kRestTolerance);
}

}  // namespace

ForceCalibration force_calibration_of(const Rig& rig, const std::string& identity) {
  ForceCalibration part;
  part.identity = identity;
  part.model = rig.arm->model.name;
  part.model_numbers = numbers_of(rig.arm->model);
  part.nominal_numbers = numbers_of(rig.nominal_arm);
  part.states_place = rig.arm->model.kind == device::ArmModel::Kind::cartesian;
  part.rest_readings = rig.arm->rest_readings;
  part.joint_offsets = rig.arm->correction.offset;
  part.reading_gains = rig.arm->correction.gain;
  return part;
}

std::string void_reason(const Rig& rig, const std::string& identity) {
  const ForceCalibration& forces = *rig.forces;
  if (!identity.empty() && identity != forces.identity)
    return fmt::format("the arm has changed: it is '{}', and was '{}'", identity, forces.identity);
  if (!rig.arm) return "the arm's calibration has gone";
  if (rig.arm->model.name != forces.model)
    return fmt::format("the arm's model has changed: it is {}, and was {}", rig.arm->model.name,
                       forces.model);
  if (!same(numbers_of(rig.arm->model), forces.model_numbers))
    return fmt::format("the arm's model has changed: {} has other lengths or angles", forces.model);
  if (!same(numbers_of(rig.nominal_arm), forces.nominal_numbers))
    return "the arm's nominal model has changed: it has other lengths or angles";
  const auto unit = device::reading_unit(rig.arm->model);
  const double tolerance = rest_tolerance(rig.arm->model);
  const auto moved = [&](const device::JointVector& now, const device::JointVector& then,
                         const char* what) -> std::string {
    if (now.size() != then.size())
      return fmt::format("the arm's model has changed: it has {} joints, and had {}", now.size(),
                         then.size());
    Eigen::Index joint = 0;
    if ((now - then).cwiseAbs().maxCoeff(&joint) <= tolerance) return "";
    return fmt::format("the arm's zero has changed: {} joint {} is {:.3f} {}, and was {:.3f}", what,
                       joint + 1, unit.per_si * now[joint], unit.name, unit.per_si * then[joint]);
  };
  if (auto text = moved(rig.arm->rest_readings, forces.rest_readings, "the rest reading of"); !text.empty())
    return text;
  if (auto text = moved(rig.arm->correction.offset, forces.joint_offsets, "the offset of"); !text.empty())
    return text;
  if (!same_within(rig.arm->correction.gain, forces.reading_gains, kGainTolerance))
    return "the arm's calibration has changed: its joints' gains are others";
  return "";
}

std::vector<MissingPart> missing_parts(const Rig& rig) {
  std::vector<MissingPart> missing;
  const auto need = [&](bool there, const char* part, const char* remedy) {
    if (!there) missing.push_back({part, remedy});
  };
  if (rig.board) {
    need(rig.arm.has_value(), "arm", "palpate rig webcam makes it");
    need(rig.camera.has_value(), "camera", "palpate calibrate camera --board BOARD.toml");
    need(rig.surface("table") != nullptr, "surface 'table'", "palpate rig webcam makes it");
    need(rig.surface("wall") != nullptr, "surface 'wall'", "palpate rig webcam makes it");
    return missing;
  }
  need(rig.tip_marker_leds.size() >= 3, "tip_marker", "write its leds_mm into the file");
  need(rig.camera_marker_leds.size() >= 3, "camera_marker", "write its leds_mm into the file");
  need(rig.pointer_leds.size() >= 3, "pointer", "write its leds_mm into the file");
  need(rig.pointer_pivot.has_value(), "pointer_pivot", "palpate calibrate pivot --marker pointer");
  need(rig.tip_pivot.has_value(), "tip_pivot", "palpate calibrate pivot");
  need(rig.arm.has_value(), "arm", "palpate calibrate arm");
  need(rig.camera.has_value(), "camera", "palpate calibrate camera");
  need(rig.hand_eye.has_value(), "hand_eye", "palpate calibrate hand-eye");
  need(rig.surface("table") != nullptr, "surface 'table'", "palpate calibrate surface --name table");
  need(rig.surface("wall") != nullptr, "surface 'wall'", "palpate calibrate surface --name wall");
  need(rig.landmarks.size() >= 3, "landmarks", "palpate calibrate landmarks, or all");
  return missing;
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace palpate::rig
