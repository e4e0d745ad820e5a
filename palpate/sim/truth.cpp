#include "palpate/sim/truth.h"

#include "palpate/core/random.h"
#include "palpate/core/units.h"

namespace palpate::sim {
namespace {

// Two cameras on one bar stand to each other so much better than the bar to the marker.
constexpr double kOnOneBar = 0.1;

Vector3 normals(std::uint64_t seed, std::string_view purpose, double sd) {
  Random random(seed, purpose);
  const double x = random.normal(sd), y = random.normal(sd), z = random.normal(sd);
  return {x, y, z};
}

// To the bit as it was where nothing was knocked.
Quaternion turned(const Quaternion& rotation, const Vector3& knock) {
  return knock.isZero(0.0) ? rotation : (so3_exp(knock) * rotation).normalized();
}

config::Corners knocked(config::Corners corners, const Vector3& about, const config::WorldFile& world) {
  if (world.knock.table.isZero(0.0) && world.knock.table_turn.isZero(0.0)) return corners;
  const Quaternion turn = so3_exp(world.knock.table_turn);
  for (auto& corner : corners) corner = about + turn * (corner - about) + world.knock.table;
  return corners;
}

void refocus(device::CameraModel& lens, const config::WorldFile& world) {
  lens.fx *= 1.0 + world.knock.focus;
  lens.fy *= 1.0 + world.knock.focus;
  lens.cx += world.knock.principal_point[0];
  lens.cy += world.knock.principal_point[1];
}

Vector3 on(const config::Corners& c, double u, double v) {
  return (1 - u) * (1 - v) * c[0] + u * (1 - v) * c[1] + u * v * c[2] + (1 - u) * v * c[3];
}

Vector3 front(const config::Corners& c) { return (c[1] - c[0]).cross(c[3] - c[0]).normalized(); }

// Half of the dots along the two side edges of the table, half on the lower part of the wall, where a head
// that looks at the table sees them: spread in depth, width and height, no three in one line by construction
// of the zigzag.
std::vector<Dot> place_landmarks(const config::Corners& table, const config::Corners& wall, int count) {
  std::vector<Dot> dots;
  const int on_table = (count + 1) / 2, on_wall = count - on_table;
  for (int i = 0; i < on_table; ++i) {
    const double along = on_table > 1 ? static_cast<double>(i) / (on_table - 1) : 0.5;
    const double inset = 0.04 + 0.03 * (i % 3);
    dots.push_back({on(table, i % 2 == 0 ? inset : 1.0 - inset, 0.15 + 0.75 * along), front(table)});
  }
  for (int i = 0; i < on_wall; ++i) {
    const double along = on_wall > 1 ? static_cast<double>(i) / (on_wall - 1) : 0.5;
    dots.push_back(
        {on(wall, 0.06 + 0.88 * along, i % 2 == 0 ? 0.10 + 0.04 * along : 0.42 - 0.05 * along), front(wall)});
  }
  return dots;
}

std::vector<Vector3> place_check_points(const config::Corners& table, const config::Corners& wall) {
  std::vector<Vector3> points;
  for (double u : {0.15, 0.325, 0.5, 0.675, 0.85})
    for (double v : {0.2, 0.4, 0.6, 0.8}) points.push_back(on(table, u, v));
  for (double u : {0.15, 0.325, 0.5, 0.675, 0.85})
    for (double v : {0.05, 0.2, 0.35}) points.push_back(on(wall, u, v));
  return points;
}

device::LensCoefficients coefficients(const std::array<double, 5>& distortion,
                                      const std::array<double, 3>& denominator, device::LensKind kind) {
  device::LensCoefficients all{};
  std::copy(distortion.begin(), distortion.end(), all.begin());
  if (kind == device::LensKind::rational) std::copy(denominator.begin(), denominator.end(), all.begin() + 5);
  return all;
}

void draw_cameras(Truth& truth, const config::WorldFile& world, std::uint64_t seed) {
  const Vector3 shift = normals(seed, "truth/camera-mount", world.camera_marker.mount_sd);
  const Vector3 turn = normals(seed, "truth/camera-turn", world.camera_marker.mount_sd_rad);
  const Quaternion mounted =
      (so3_exp(turn) * rotation_from_xyz(world.camera_marker.camera_rotation)).normalized();
  truth.X_marker_camera = {turned(mounted, world.knock.camera_turn),
                           world.camera_marker.camera_translation + shift + world.knock.camera};

  const auto kind = device::lens_kind(world.camera.lens).value_or(device::LensKind::brown);
  const auto& camera = world.camera;
  truth.lens = {camera.size[0],
                camera.size[1],
                camera.fx,
                camera.fy,
                camera.cx,
                camera.cy,
                coefficients(camera.distortion, camera.denominator, kind),
                kind};
  truth.right_lens = {camera.size[0],
                      camera.size[1],
                      camera.right_fx,
                      camera.right_fy,
                      camera.right_cx,
                      camera.right_cy,
                      coefficients(camera.right_distortion, camera.right_denominator, kind),
                      kind};
  refocus(truth.lens, world);
  const Vector3 beside = normals(seed, "truth/right-camera-mount", kOnOneBar * world.camera_marker.mount_sd);
  const Vector3 askew =
      normals(seed, "truth/right-camera-turn", kOnOneBar * world.camera_marker.mount_sd_rad);
  truth.X_marker_right_camera =
      truth.X_marker_camera * Pose<CameraOptical, CameraOptical>{
                                  so3_exp(askew), Vector3(world.camera.stereo_baseline, 0.0, 0.0) + beside};
}

}  // namespace

Vector3 tip_marker_normal() { return Vector3::UnitZ(); }
Vector3 camera_marker_normal() {
  const double up = radians_from_degrees(35.0);
  return {0.0, std::sin(up), std::cos(up)};
}
Vector3 pointer_normal() { return -Vector3::UnitZ(); }
Quaternion tip_marker_mount() {
  // Marker z to Tip (0, 0.64, -0.77): up and forward, where the tracker hangs.
  return Quaternion(Eigen::AngleAxisd(radians_from_degrees(-140.0), Vector3::UnitX()));
}

Truth draw_truth(const config::WorldFile& world, std::uint64_t seed) {
  Truth truth;
  Random lengths(seed, "truth/arm-lengths");
  truth.lengths.l1 = world.arm.lengths[0] + lengths.normal(world.arm.length_sd);
  truth.lengths.l2 = world.arm.lengths[1] + lengths.normal(world.arm.length_sd);
  truth.joints.gain = Vector3::Ones() + normals(seed, "truth/arm-gains", world.arm.gain_sd);
  truth.joints.offset = normals(seed, "truth/arm-offsets", world.arm.offset_sd);
  truth.gimbal.gain = Vector3::Ones() + normals(seed, "truth/gimbal-gains", world.arm.gimbal_gain_sd);
  truth.gimbal.offset = normals(seed, "truth/gimbal-offsets", world.arm.gimbal_offset_sd);
  if (world.states_place())
    truth.delta = DeltaArm::built({world.delta.length_sd, world.delta.azimuth_sd, world.delta.zero_sd}, seed);
  truth.X_world_base = {turned(rotation_from_xyz(world.arm.rotation), world.knock.base_turn),
                        world.arm.translation + world.knock.base};

  truth.tip_in_marker =
      world.tip_marker.tip + normals(seed, "truth/tip-mount", world.tip_marker.mount_sd) + world.knock.tip;
  truth.X_tip_marker = {tip_marker_mount(), -(tip_marker_mount() * truth.tip_in_marker)};

  truth.pointer_tip = world.pointer.tip + world.knock.pointer_tip;
  draw_cameras(truth, world, seed);
  truth.table = knocked(world.scene.table, world.scene.table[0], world);
  truth.wall = knocked(world.scene.wall, world.scene.table[0], world);
  truth.landmarks = place_landmarks(truth.table, truth.wall, world.scene.landmarks);
  truth.check_points = place_check_points(truth.table, truth.wall);

  // The board leans back on a stand left of the arm, over the middle of the table: its printed side (-z) to
  // the head.
  const Vector3 place = on(truth.table, 0.30, 0.40) + 0.13 * front(truth.table);
  const Vector3 z = (place - world.head.eye).normalized();
  const Vector3 x = (truth.table[1] - truth.table[0]).normalized();
  Matrix3 R;
  R.col(2) = z;
  R.col(0) = (x - z * z.dot(x)).normalized();
  R.col(1) = z.cross(R.col(0));
  truth.X_world_board = {Quaternion(R),
                         place - R * Vector3(0.100, 0.0625, 0.0)};  // its middle stands at `place`
  return truth;
}

device::ArmModel makers_arm(const config::WorldFile& world) {
  if (world.states_place()) return device::laboratory_delta();
  device::ArmModel model;
  model.lengths = {world.arm.lengths[0], world.arm.lengths[1]};
  return model;
}

ArmTruth arm_with_first_offset_zero(const Truth& truth) {
  ArmTruth arm{truth.lengths, truth.joints, truth.gimbal, truth.X_world_base};
  // A turn by offset 1 about y through (0, 0, -l1), the first joint's axis.
  const Quaternion turn(Eigen::AngleAxisd(truth.joints.offset[0], Vector3::UnitY()));
  const Vector3 axis(0.0, 0.0, -truth.lengths.l1);
  const Pose<ArmBase, ArmBase> about_axis{turn, axis - turn * axis};
  arm.joints.offset[0] = 0.0;
  arm.X_world_base = truth.X_world_base * about_axis;
  return arm;
}

}  // namespace palpate::sim
