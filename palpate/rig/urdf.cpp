#include "palpate/rig/urdf.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::rig {
namespace {

constexpr double kPlate = 0.001;  // m, thickness of a surface's box

// Letters, digits and '_': what every reader of URDF takes as a name, and XML as text.
std::string plain(const std::string& name) {
  std::string text;
  for (const unsigned char c : name) text += std::isalnum(c) != 0 && c < 128 ? static_cast<char>(c) : '_';
  return text.empty() ? "_" : text;
}

std::string in_xml(const std::string& text) {
  std::string safe;
  for (const char c : one_line(text)) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '"')
      safe += "&quot;";
    else
      safe += c;
  }
  return safe;
}

// Fixed axes x, y, z in turn, as URDF has it: R = Rz(yaw) Ry(pitch) Rx(roll).
Vector3 roll_pitch_yaw(const Matrix3& R) {
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  if (std::abs(std::cos(pitch)) < 1e-9)  // upright: only roll - yaw, or their sum, is known
    return {0.0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

std::string origin(const Vector3& place, const Matrix3& R) {
  const Vector3 turn = roll_pitch_yaw(R);
  return fmt::format("<origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/>", place.x(), place.y(), place.z(), turn.x(),
                     turn.y(), turn.z());
}

// Writes links and the joints that hold them.
class Description {
 public:
  std::string add_link(const std::string& wanted, const std::string& visual = "") {
    std::string name = plain(wanted);
    for (int i = 2; !names_.insert(name).second; ++i) name = fmt::format("{}_{}", plain(wanted), i);
    text_ += visual.empty() ? fmt::format("  <link name=\"{}\"/>\n", name)
                            : fmt::format("  <link name=\"{}\"><visual>{}</visual></link>\n", name, visual);
    return name;
  }
  void fix(const std::string& parent, const std::string& child, const Vector3& place, const Matrix3& R,
           const char* type = "fixed") {
    text_ += fmt::format(
        "  <joint name=\"{2}_in_{1}\" type=\"{0}\"><parent link=\"{1}\"/><child link=\"{2}\"/>{3}</joint>\n",
        type, parent, child, origin(place, R));
  }
  void turn(const std::string& joint, const std::string& parent, const std::string& child,
            const Vector3& place, const Matrix3& R, const Vector3& axis, const std::string& rest = "",
            const device::JointRange& range = {}) {
    const std::string limit =
        range.known() ? fmt::format("<limit lower=\"{}\" upper=\"{}\" effort=\"0\" velocity=\"0\"/>",
                                    range.low, range.high)
                      : std::string();
    text_ += fmt::format(
        "  <joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/>{}<axis xyz=\"{:g} {:g} "
        "{:g}\"/>{}{}"
        "</joint>\n",
        joint, range.known() ? "revolute" : "continuous", parent, child, origin(place, R), axis.x(), axis.y(),
        axis.z(), limit, rest);
  }
  void slide(const std::string& joint, const std::string& parent, const std::string& child,
             const Vector3& axis, const device::JointRange& range) {
    text_ += fmt::format(
        "  <joint name=\"{}\" type=\"prismatic\"><parent link=\"{}\"/><child link=\"{}\"/><axis xyz=\"{:g} "
        "{:g} "
        "{:g}\"/><limit lower=\"{}\" upper=\"{}\" effort=\"0\" velocity=\"0\"/></joint>\n",
        joint, parent, child, axis.x(), axis.y(), axis.z(), range.low, range.high);
  }
  void comment(const std::string& words) {
    std::string safe = words;
    for (auto at = safe.find("--"); at != safe.npos; at = safe.find("--")) safe.replace(at, 2, "- ");
    text_ += "  <!-- " + safe + " -->\n";
  }
  std::string take(const std::string& name) {
    return fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n{}</robot>\n", in_xml(name), text_);
  }

 private:
  std::set<std::string> names_;
  std::string text_;
};

// The gimbal turns the stylus about y, then x, then z, at the tip.
std::string add_gimbal(Description& urdf, const std::string& forearm, const Vector3& tip,
                       const Matrix3& turn) {
  const std::string first = urdf.add_link("gimbal_link_1"), second = urdf.add_link("gimbal_link_2"),
                    end = urdf.add_link("tip");
  urdf.turn("gimbal_1", forearm, first, tip, turn, Vector3::UnitY());
  urdf.turn("gimbal_2", first, second, Vector3::Zero(), Matrix3::Identity(), Vector3::UnitX());
  urdf.turn("gimbal_3", second, end, Vector3::Zero(), Matrix3::Identity(), Vector3::UnitZ());
  return end;
}

std::string add_phantom(Description& urdf, const std::string& base, const device::PhantomLengths& lengths) {
  const Matrix3 I = Matrix3::Identity();
  const Vector3 up = -Vector3::UnitX();  // a growing angle raises what points along z
  const std::string turntable = urdf.add_link("link_1"), upper = urdf.add_link("link_2"),
                    elbow = urdf.add_link("elbow"), forearm = urdf.add_link("link_3");
  urdf.turn("joint_1", base, turntable, {0.0, lengths.l2, -lengths.l1}, I, Vector3::UnitY());
  urdf.turn("joint_2", turntable, upper, Vector3::Zero(), I, up);
  urdf.turn("parallelogram", upper, elbow, {0.0, 0.0, lengths.l1}, I, up,
            "<mimic joint=\"joint_2\" multiplier=\"-1\"/>");
  urdf.turn("joint_3", elbow, forearm, Vector3::Zero(), I, up);
  return add_gimbal(urdf, forearm, {0.0, -lengths.l2, 0.0}, I);
}

std::string add_chain(Description& urdf, const std::string& base, const device::ArmModel& model) {
  std::string last = base;
  Vector3 place = Vector3::Zero();
  Matrix3 R = Matrix3::Identity();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const device::DhJoint& row = model.joints[j];
    const std::string link = urdf.add_link(fmt::format("link_{}", j + 1));
    const Matrix3 offset = Eigen::AngleAxisd(row.theta_offset, Vector3::UnitZ()).toRotationMatrix();
    urdf.turn(fmt::format("joint_{}", j + 1), last, link, place, R * offset, Vector3::UnitZ(), "", row.range);
    place = {row.a, 0.0, row.d};
    R = Eigen::AngleAxisd(row.alpha, Vector3::UnitX()).toRotationMatrix();
    last = link;
  }
  return add_gimbal(urdf, last, place + R * model.tool, R * model.tool_turn.toRotationMatrix());
}

std::string add_cartesian(Description& urdf, const std::string& base, const device::ArmModel& model) {
  std::string last = base;
  for (int i = 0; i < 3; ++i) {
    const std::string link = urdf.add_link(fmt::format("link_{}", i + 1));
    urdf.slide(fmt::format("joint_{}", i + 1), last, link, Vector3::Unit(i),
               model.places[static_cast<std::size_t>(i)]);
    last = link;
  }
  return add_gimbal(urdf, last, Vector3::Zero(), Matrix3::Identity());
}

std::string listed(const Eigen::Ref<const Eigen::VectorXd>& values, double scale) {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    text += fmt::format("{}{}", i > 0 ? ", " : "", scale * values[i]);
  return text;
}

void add_arm(Description& urdf, const std::string& world, const ArmCalibration& arm) {
  const bool cartesian = arm.model.kind == device::ArmModel::Kind::cartesian;
  if (cartesian)
    urdf.comment(
        fmt::format("Places are corrected ones, mm at the strains and bends of docs/theory/arm.md: {}. Of "
                    "the gimbal: {}, {}, "
                    "{}; {}, {}, {} deg.",
                    listed(arm.model.correction.terms, kMillimetresPerMetre), arm.gimbal_gain[0],
                    arm.gimbal_gain[1], arm.gimbal_gain[2], kDegreesPerRadian * arm.gimbal_offset[0],
                    kDegreesPerRadian * arm.gimbal_offset[1], kDegreesPerRadian * arm.gimbal_offset[2]));
  else
    urdf.comment(fmt::format(
        "Angles are corrected ones, gain * reading + offset: gains {}; offsets {} deg. Of the gimbal: {}, "
        "{}, "
        "{}; {}, {}, {} deg.",
        listed(arm.correction.gain, 1.0), listed(arm.correction.offset, kDegreesPerRadian),
        arm.gimbal_gain[0], arm.gimbal_gain[1], arm.gimbal_gain[2], kDegreesPerRadian * arm.gimbal_offset[0],
        kDegreesPerRadian * arm.gimbal_offset[1], kDegreesPerRadian * arm.gimbal_offset[2]));
  const std::string base = urdf.add_link("arm_base");
  urdf.fix(world, base, arm.X_world_base.translation, arm.X_world_base.matrix());
  const std::string tip = arm.model.kind == device::ArmModel::Kind::phantom
                              ? add_phantom(urdf, base, arm.model.lengths)
                          : cartesian ? add_cartesian(urdf, base, arm.model)
                                      : add_chain(urdf, base, arm.model);
  const std::string marker = urdf.add_link("tip_marker");
  const Matrix3 turn = arm.R_tip_marker.toRotationMatrix();
  urdf.fix(tip, marker, -(turn * arm.tip_in_marker), turn);
}

void add_cameras(Description& urdf, const std::string& world, const Rig& rig) {
  if (!rig.hand_eye && !rig.right_hand_eye) return;
  const std::string marker = urdf.add_link("camera_marker");
  urdf.fix(world, marker, Vector3::Zero(), Matrix3::Identity(), "floating");
  const auto add = [&](const std::optional<HandEyeCalibration>& hand_eye, const char* name) {
    if (!hand_eye) return;
    const auto& X = hand_eye->X_marker_camera;
    urdf.fix(marker, urdf.add_link(name), X.translation, X.matrix());
  };
  add(rig.hand_eye, "camera_optical");
  add(rig.right_hand_eye, "right_camera_optical");
}

}  // namespace

std::string urdf_of(const Rig& rig) {
  Description urdf;
  const std::string world = urdf.add_link("world");
  add_arm(urdf, world, *rig.arm);
  add_cameras(urdf, world, rig);
  for (const auto& surface : rig.surfaces) {
    const Vector3 middle(0.5 * surface.width, 0.5 * surface.height, -0.5 * kPlate);
    const std::string link =
        urdf.add_link(surface.name, origin(middle, Matrix3::Identity()) +
                                        fmt::format("<geometry><box size=\"{} {} {}\"/></geometry>",
                                                    surface.width, surface.height, kPlate));
    urdf.fix(world, link, surface.X_world_rectangle.translation, surface.X_world_rectangle.matrix());
  }
  for (const auto& body : rig.objects) {
    const std::string link = urdf.add_link(
        body.name, fmt::format("<geometry><mesh filename=\"{0}\" scale=\"{1} {1} {1}\"/></geometry>",
                               in_xml(body.mesh), body.metres_per_unit));
    urdf.fix(world, link, body.position, body.rotation.toRotationMatrix());
  }
  return urdf.take(rig.name);
}

}  // namespace palpate::rig
