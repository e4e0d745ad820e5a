#include "palpate/render/arm_shape.h"

#include <algorithm>
#include <cmath>

namespace palpate::render {
namespace {

Quaternion about(const Vector3& axis, double angle) { return Quaternion(Eigen::AngleAxisd(angle, axis)); }

// The lower rod of the parallelogram runs beside the upper arm, this far behind the elbow on the forearm's
// line.
constexpr double kCrank = 0.034;

}  // namespace

std::vector<ArmPart> arm_parts(const device::PhantomLengths& lengths, const ArmShapeSettings& settings) {
  std::vector<ArmPart> parts;
  // Thin things need fewer corners for the same distance between outline and circle.
  const auto corners = [&settings](double radius) {
    constexpr double widest = 0.030;  // m; from here on `segments`
    return std::max(
        6, static_cast<int>(std::lround(settings.segments * std::sqrt(std::min(1.0, radius / widest)))));
  };
  const auto tube = [&](ArmFrame frame, ArmLook look, const Vector3& a, const Vector3& b, double radius) {
    parts.push_back({scene::cylinder_mesh(a, b, radius, corners(radius)), frame, look});
  };
  const auto sphere = [&](ArmFrame frame, ArmLook look, const Vector3& centre, double radius) {
    scene::TriangleMesh mesh = scene::sphere_mesh(radius, corners(radius) / 2, corners(radius));
    for (Vector3& v : mesh.vertices) v += centre;
    parts.push_back({std::move(mesh), frame, look});
  };
  const auto box = [&](ArmFrame frame, ArmLook look, const Vector3& low, const Vector3& high) {
    parts.push_back({scene::box_mesh(low, high), frame, look});
  };
  // Base frame: under the shoulder, origin at the shoulder (where the first two axes meet).
  const double foot = -(lengths.l2 + settings.base_below);
  box(ArmFrame::base, ArmLook::black, {-0.085, foot, -0.10}, {0.085, foot + 0.018, 0.075});
  tube(ArmFrame::base, ArmLook::dark, {0, foot + 0.018, 0}, {0, foot + 0.055, 0}, 0.055);
  tube(ArmFrame::base, ArmLook::black, {0, foot + 0.055, 0}, {0, -0.125, 0}, 0.030);
  tube(ArmFrame::base, ArmLook::metal, {0, -0.125, 0}, {0, -0.112, 0}, 0.062);
  // Turntable: the drum that turns about the vertical, two motors lying across, side cheeks.
  tube(ArmFrame::turntable, ArmLook::dark, {0, -0.112, 0}, {0, -0.070, 0}, 0.046);
  box(ArmFrame::turntable, ArmLook::black, {-0.036, -0.074, -0.030}, {-0.028, 0.022, 0.030});
  box(ArmFrame::turntable, ArmLook::black, {0.028, -0.074, -0.030}, {0.036, 0.022, 0.030});
  tube(ArmFrame::turntable, ArmLook::metal, {-0.044, 0, 0}, {0.044, 0, 0}, 0.011);
  tube(ArmFrame::turntable, ArmLook::dark, {-0.082, -0.040, -0.048}, {-0.036, -0.040, -0.048}, 0.019);
  tube(ArmFrame::turntable, ArmLook::dark, {0.036, -0.040, -0.048}, {0.082, -0.040, -0.048}, 0.019);
  tube(ArmFrame::turntable, ArmLook::metal, {-0.084, -0.040, -0.048}, {-0.082, -0.040, -0.048}, 0.016);
  tube(ArmFrame::turntable, ArmLook::metal, {0.082, -0.040, -0.048}, {0.084, -0.040, -0.048}, 0.016);
  // Upper arm (z towards the elbow) with its cable sector, and the rod of the parallelogram below it.
  tube(ArmFrame::upper, ArmLook::metal, {0, 0, -0.045}, {0, 0, lengths.l1}, 0.0095);
  tube(ArmFrame::upper, ArmLook::dark, {0.014, 0, 0}, {0.021, 0, 0}, 0.052);
  tube(ArmFrame::upper, ArmLook::black, {-0.014, 0, lengths.l1}, {0.014, 0, lengths.l1}, 0.015);
  tube(ArmFrame::upper, ArmLook::black, {0, 0, -0.070}, {0, 0, -0.040}, 0.021);  // counterweight
  tube(ArmFrame::rod, ArmLook::metal, {0.012, 0, 0}, {0.012, 0, lengths.l1}, 0.0045);
  tube(ArmFrame::rod, ArmLook::dark, {-0.021, 0, 0}, {-0.014, 0, 0}, 0.038);
  // Forearm (-y towards the tip).
  tube(ArmFrame::forearm, ArmLook::metal, {0, kCrank, 0}, {0, -lengths.l2 + 0.020, 0}, 0.0080);
  tube(ArmFrame::forearm, ArmLook::black, {-0.016, kCrank, 0}, {0.016, kCrank, 0}, 0.010);
  tube(ArmFrame::forearm, ArmLook::black, {0, -lengths.l2 + 0.036, 0}, {0, -lengths.l2 + 0.014, 0}, 0.0125);
  // Stylus: the gimbal's knuckle at the tip, the handle behind it.
  sphere(ArmFrame::stylus, ArmLook::dark, Vector3::Zero(), 0.0125);
  tube(ArmFrame::stylus, ArmLook::metal, {0, 0, 0}, {0, 0, 0.030}, 0.0050);
  tube(ArmFrame::stylus, ArmLook::black, {0, 0, 0.028}, {0, 0, 0.112}, 0.0078);
  // Marker: a star of thin bars, each ending in an LED, so that it hides little of what is behind it.
  if (!settings.leds.empty()) {
    tube(ArmFrame::marker, ArmLook::metal, {0, 0, -0.020}, {0, 0, 0.002}, 0.0105);
    for (const Vector3& led : settings.leds) {
      const Vector3 end = led - Vector3(0, 0, 0.005);
      if (led.head<2>().norm() > 0.012) tube(ArmFrame::marker, ArmLook::black, {0, 0, -0.006}, end, 0.0032);
      tube(ArmFrame::marker, ArmLook::dark, end - Vector3(0, 0, 0.003), led - Vector3(0, 0, 0.0005), 0.0060);
      sphere(ArmFrame::marker, ArmLook::red, led, 0.0036);
    }
  }
  return parts;
}

std::array<PartPose, static_cast<std::size_t>(ArmFrame::count)> arm_part_poses(
    const device::PhantomLengths& lengths, const Vector3& theta, const Vector3& gimbal,
    const Pose<Tip, TipMarker>& X_tip_marker) {
  std::array<PartPose, static_cast<std::size_t>(ArmFrame::count)> poses;
  const auto at = [&](ArmFrame frame) -> PartPose& { return poses[static_cast<std::size_t>(frame)]; };
  const Vector3 shoulder(0, lengths.l2, -lengths.l1);
  const Quaternion turn = about(Vector3::UnitY(), theta[0]);
  const Quaternion upper = turn * about(Vector3::UnitX(), -theta[1]);
  const Quaternion forearm = turn * about(Vector3::UnitX(), -theta[2]);
  const Vector3 elbow = shoulder + upper * Vector3(0, 0, lengths.l1);
  at(ArmFrame::base) = {Quaternion::Identity(), shoulder};
  at(ArmFrame::turntable) = {turn, shoulder};
  at(ArmFrame::upper) = {upper, shoulder};
  at(ArmFrame::rod) = {upper, shoulder + forearm * Vector3(0, kCrank, 0)};
  at(ArmFrame::forearm) = {forearm, elbow};
  const Pose<ArmBase, Tip> X_base_tip = device::phantom_pose(theta, gimbal, lengths);
  at(ArmFrame::stylus) = {X_base_tip.rotation, X_base_tip.translation};
  const Pose<ArmBase, TipMarker> X_base_marker = X_base_tip * X_tip_marker;
  at(ArmFrame::marker) = {X_base_marker.rotation, X_base_marker.translation};
  return poses;
}

}  // namespace palpate::render
