#include "palpate/rig/rig.h"

#include <algorithm>

#include <ctime>
#include <set>

#include "palpate/core/file.h"
#include "palpate/core/toml.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_kinematics.h"
#include "palpate/device/arm_model_file.h"
#include "palpate/rig/file_mixup.h"
#include "palpate/rig/internal/filed_lens.h"
#include "palpate/rig/internal/rig_forces.h"
#include "palpate/rig/internal/rig_picture.h"
#include "palpate/rig/internal/rig_verifications.h"
#include "palpate/rig/internal/rig_version.h"

namespace palpate::rig {
namespace {

constexpr double kMm = 1.0 / kMillimetresPerMetre, kMm2 = kMm * kMm;

constexpr std::size_t kSurfaceUnknowns = 8;
constexpr NumberRange kLensFocus{1.0, 1e6}, kGain{0.5, 2.0}, kAngleDeg{-720.0, 720.0}, kPlaceMm{-1e5, 1e5},
    kLengthMm{1.0, 1e5};

Vector3 vector_of(const TomlTable& table, std::string_view key, double unit, NumberRange range) {
  const auto v = table.numbers<3>(key, range);
  return unit * Vector3(v[0], v[1], v[2]);
}

Quaternion rotation_of(const TomlTable& table, std::string_view key) {
  const auto v = table.numbers<4>(key, {-1.0, 1.0});
  const Quaternion q(v[0], v[1], v[2], v[3]);
  // printed with all digits; further off than this, it is no rotation but a mistake of whoever edited the
  // file
  if (table.has(key) && std::abs(q.norm() - 1.0) > 1e-6)
    table.complain(key, fmt::format("is no rotation: w, x, y, z have length {:g}, 1 is expected", q.norm()));
  return q.norm() > 0.5 ? q : Quaternion::Identity();
}

// Square, symmetric, no negative variance, no correlation above 1.
Eigen::MatrixXd covariance_of(const TomlTable& table, std::string_view key, std::size_t size, double unit) {
  const auto n = static_cast<Eigen::Index>(size);
  const auto rows = table.rows(key, size, size);
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  if (rows.size() != size) return C;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      C(i, j) = unit * rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  const double scale = C.cwiseAbs().maxCoeff();
  if ((C - C.transpose()).cwiseAbs().maxCoeff() > 1e-9 * scale)
    table.complain(key, "is not symmetric; a covariance is expected");
  else if (C.diagonal().minCoeff() < 0)
    table.complain(key, "has a negative variance on its diagonal");
  else
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < i; ++j)
        if (C(i, j) * C(i, j) > (1 + 1e-9) * C(i, i) * C(j, j)) {
          table.complain(key, fmt::format("entry {}, {} is larger than the variances allow", i + 1, j + 1));
          return C;
        }
  return C;
}

Eigen::MatrixXd optional_covariance_of(const TomlTable& table, std::string_view key, std::size_t size) {
  if (table.has(key)) return covariance_of(table, key, size, 1.0);
  table.expect(key);
  return {};
}

Provenance provenance_of(const TomlTable& table, std::string_view rms_key = "rms_mm") {
  Provenance from;
  from.date = table.text_or("date", "");
  from.data_hash = table.text_or("data_hash", "");
  from.method = table.text_or("method", "");
  from.rms_mm = table.number_or(rms_key, 0.0, kNotNegative);
  std::tm when{};
  if (!from.date.empty() &&
      (from.date.size() != 20 || ::strptime(from.date.c_str(), "%Y-%m-%dT%H:%M:%SZ", &when) == nullptr))
    table.complain("date",
                   fmt::format("is '{}', a UTC time such as 2026-01-31T12:00:00Z is expected", from.date));
  return from;
}

std::vector<Vector3> leds_of(const TomlTable& table) {
  std::vector<Vector3> leds;
  if (!table.exists()) return leds;
  const auto rows = table.rows("leds_mm", 3, 0, kPlaceMm);
  for (const auto& row : rows) leds.push_back(kMm * Vector3(row[0], row[1], row[2]));
  if (!rows.empty() && rows.size() < 3)
    table.complain("leds_mm", fmt::format("has {} LEDs, at least 3 are needed for a pose", rows.size()));
  return leds;
}

std::optional<PivotCalibration> pivot_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  PivotCalibration pivot;
  pivot.tip_in_marker = vector_of(table, "tip_mm", kMm, kPlaceMm);
  pivot.covariance = covariance_of(table, "covariance_mm2", 3, kMm2);
  pivot.from = provenance_of(table);
  return pivot;
}

device::JointVector joints_of(const TomlTable& table, std::string_view key, Eigen::Index joints, double unit,
                              NumberRange range) {
  const auto v = table.numbers(key, static_cast<std::size_t>(joints), range);
  device::JointVector list = device::JointVector::filled(joints, 0.0);
  for (Eigen::Index j = 0; j < joints; ++j) list[j] = unit * v[static_cast<std::size_t>(j)];
  return list;
}

// Of [nominal_arm] or [arm]: a PHANToM's lengths, a chain (type = "dh") or a Cartesian arm.
device::ArmModel arm_model_of(const TomlTable& table, std::string_view name_key) {
  device::ArmModel model;
  table.expect("type");
  const std::string type =
      table.has("type") ? table.choice("type", {"dh", "phantom", "cartesian"}) : "phantom";
  if (type == "cartesian") {
    model.name = table.text(name_key);
    device::read_cartesian(table, model);
    return model;
  }
  if (type == "dh") {
    model.name = table.text(name_key);
    device::read_dh_chain(table, model);
    if (table.has("lengths_mm"))
      table.complain("lengths_mm", "is a PHANToM's; this arm is a chain (type), which has joint tables");
    if (const auto fine = device::check_runnable(model); !fine) table.complain("joint", fine.error().message);
    return table.has("joint") && device::check_runnable(model) ? model : device::ArmModel{};
  }
  if (table.has("joint")) table.complain("joint", "belongs to a chain; type = \"dh\" is expected beside it");
  const auto lengths = table.numbers<2>("lengths_mm", kLengthMm);
  model.lengths = {kMm * lengths[0], kMm * lengths[1]};
  return model;
}

std::optional<ArmCalibration> arm_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  ArmCalibration arm;
  const std::string name = table.text("model");
  arm.model = arm_model_of(table, "model");
  arm.model.name = name;
  const Eigen::Index joints = arm.model.joint_count();
  const bool cartesian = arm.model.kind == device::ArmModel::Kind::cartesian;
  arm.correction = device::JointCorrection::none(joints);
  if (!cartesian) {
    arm.correction.gain = joints_of(table, "gains", joints, 1.0, kGain);
    arm.correction.offset = joints_of(table, "offsets_deg", joints, 1.0 / kDegreesPerRadian, kAngleDeg);
  }
  const auto base = table.table("base");
  arm.X_world_base = {rotation_of(base, "rotation_qwxyz"), vector_of(base, "translation_mm", kMm, kPlaceMm)};
  arm.tip_in_marker = vector_of(table, "tip_mm", kMm, kPlaceMm);
  arm.R_tip_marker = rotation_of(table, "marker_in_tip_qwxyz");
  arm.gimbal_gain = vector_of(table, "gimbal_gains", 1.0, kGain);
  arm.gimbal_offset = vector_of(table, "gimbal_offsets_deg", 1.0 / kDegreesPerRadian, kAngleDeg);
  arm.covariance = optional_covariance_of(table, "covariance_si", covariance_order(arm.model).size());
  const std::string rest = cartesian ? "rest_readings_mm" : "rest_readings_deg";
  arm.rest_known = table.has(rest);
  table.expect(rest);
  if (!arm.rest_known)
    arm.rest_readings = device::JointVector::filled(joints, 0.0);
  else
    arm.rest_readings = cartesian ? joints_of(table, rest, joints, kMm, kPlaceMm)
                                  : joints_of(table, rest, joints, 1.0 / kDegreesPerRadian, kAngleDeg);
  arm.held_out_mean = kMm * table.number_or("held_out_mean_mm", 0.0, kNotNegative);
  arm.from = provenance_of(table);
  return arm;
}

std::optional<CameraCalibration> camera_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  CameraCalibration camera;
  auto& m = camera.model;
  m.width = static_cast<int>(table.integer("width_px", {1, 100000}));
  m.height = static_cast<int>(table.integer("height_px", {1, 100000}));
  m.fx = table.number("fx_px", kLensFocus), m.fy = table.number("fy_px", kLensFocus);
  m.cx = table.number("cx_px", {-1e5, 1e5}), m.cy = table.number("cy_px", {-1e5, 1e5});
  if (table.has("lens"))
    m.kind = device::lens_kind(table.choice("lens", {device::kLensWords.begin(), device::kLensWords.end()}))
                 .value_or(m.kind);
  if (m.kind == device::LensKind::rational) {
    m.distortion = table.numbers<device::kMostCoefficients>("distortion", {-1e4, 1e4});
  } else {
    const auto five = table.numbers<5>("distortion", {-1e4, 1e4});
    std::copy(five.begin(), five.end(), m.distortion.begin());
  }
  if (m.kind == device::LensKind::fisheye && m.distortion[4] != 0.0)
    table.complain("distortion", "a fisheye lens has four numbers, k1 k2 k3 k4; 0 is expected as the fifth");
  camera.covariance = with_all_parameters(
      optional_covariance_of(table, "covariance", static_cast<std::size_t>(filed_lens_parameters(m.kind))),
      m.kind);
  camera.from = provenance_of(table, "rms_px");
  camera.encoding = encoding_of(table);
  return camera;
}

std::optional<HandEyeCalibration> hand_eye_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  HandEyeCalibration hand_eye;
  hand_eye.X_marker_camera = {rotation_of(table, "rotation_qwxyz"),
                              vector_of(table, "translation_mm", kMm, kPlaceMm)};
  hand_eye.covariance = covariance_of(table, "covariance_si", 6, 1.0);
  hand_eye.from = provenance_of(table);
  return hand_eye;
}

std::optional<HeadsetCalibration> headset_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  HeadsetCalibration headset;
  headset.X_eyes_camera = {rotation_of(table, "rotation_qwxyz"),
                           vector_of(table, "translation_mm", kMm, kPlaceMm)};
  headset.covariance = covariance_of(table, "covariance_si", 6, 1.0);
  headset.delay_s = table.number("delay_s", {-1.0, 1.0});
  headset.delay_std_s = table.number("delay_std_s", {0.0, 1.0});
  headset.from = provenance_of(table);
  return headset;
}

std::optional<DelayCalibration> delays_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  DelayCalibration delays;
  delays.tracker_after_arm_s = table.number("tracker_after_arm_s");
  delays.camera_after_tracker_s = table.number("camera_after_tracker_s");
  delays.tracker_std_s = table.number("tracker_std_s", kNotNegative);
  delays.camera_std_s = table.number("camera_std_s", kNotNegative);
  delays.from = provenance_of(table);
  return delays;
}

SurfaceCalibration surface_of(const TomlTable& table, std::set<std::string>& names) {
  SurfaceCalibration surface;
  surface.name = table.text("name");
  if (table.has("name") && (surface.name.empty() || !names.insert(surface.name).second))
    table.complain("name", fmt::format("'{}' is empty or used twice", surface.name));
  surface.X_world_rectangle = {rotation_of(table, "rotation_qwxyz"),
                               vector_of(table, "corner_mm", kMm, kPlaceMm)};
  surface.width = kMm * table.number("width_mm", kLengthMm);
  surface.height = kMm * table.number("height_mm", kLengthMm);
  surface.covariance = optional_covariance_of(table, "covariance_si", kSurfaceUnknowns);
  surface.from = provenance_of(table);
  surface.touch.sd = kMm * table.number_or("touch_sd_mm", 0.0, {0.0, 100.0});
  surface.touch.freedoms = table.number_or("touch_freedoms", 0.0, {0.0, 1e9});
  return surface;
}

Landmark landmark_of(const TomlTable& table) {
  Landmark landmark;
  landmark.place.m = vector_of(table, "place_mm", kMm, kPlaceMm);
  landmark.normal = vector_of(table, "normal", 1.0, {-1.0, 1.0});
  if (table.has("normal") && std::abs(landmark.normal.norm() - 1.0) > 1e-6)
    table.complain("normal", fmt::format("has length {:g}, 1 is expected", landmark.normal.norm()));
  landmark.diameter = kMm * table.number("diameter_mm", {0.1, 1000.0});
  landmark.covariance = covariance_of(table, "covariance_mm2", 3, kMm2);
  return landmark;
}

}  // namespace

Expected<Rig> parse_rig(std::string_view content, const std::string& source) {
  const auto file = parse_toml(content, source);
  if (!file) return tl::unexpected(file_of_another_form(content, source).value_or(file.error()));
  if (auto fine = is_no_world_file(*file, source); !fine) return tl::unexpected(fine.error());
  Rig rig;
  if (const auto version = file->integer("rig_version", {1, 1'000'000});
      version != kRigVersion && file->has("rig_version"))
    file->complain("rig_version", fmt::format("is {}, this program reads {}", version, kRigVersion));
  rig.name = file->text_or("name", rig.name);
  const auto nominal = file->table("nominal_arm");
  if (nominal.exists()) rig.nominal_arm = arm_model_of(nominal, "name");
  rig.tip_marker_leds = leds_of(file->table("tip_marker"));
  rig.camera_marker_leds = leds_of(file->table("camera_marker"));
  rig.pointer_leds = leds_of(file->table("pointer"));
  rig.tip_pivot = pivot_of(file->table("tip_pivot"));
  rig.pointer_pivot = pivot_of(file->table("pointer_pivot"));
  rig.arm = arm_of(file->table("arm"));
  if (rig.arm && !nominal.exists() && rig.arm->model.kind != device::ArmModel::Kind::phantom) {
    rig.nominal_arm = rig.arm->model;
    rig.nominal_arm.correction.terms.setZero();
  }
  if (rig.arm && rig.arm->model.joint_count() != rig.nominal_arm.joint_count())
    file->complain("arm", fmt::format("has {} joints, nominal_arm has {}; the same arm is expected",
                                      rig.arm->model.joint_count(), rig.nominal_arm.joint_count()));
  rig.forces = forces_of(file->table("forces"));
  rig.verifications = verifications_of(*file);
  rig.camera = camera_of(file->table("camera"));
  rig.hand_eye = hand_eye_of(file->table("hand_eye"));
  rig.right_camera = camera_of(file->table("right_camera"));
  rig.right_hand_eye = hand_eye_of(file->table("right_hand_eye"));
  rig.headset = headset_of(file->table("headset"));
  read_picture_parts(*file, rig);
  rig.delays = delays_of(file->table("delays"));
  std::set<std::string> names;
  for (const auto& table : file->tables("surface")) rig.surfaces.push_back(surface_of(table, names));
  for (const auto& table : file->tables("landmark")) rig.landmarks.push_back(landmark_of(table));
  if (const auto from = file->table("landmarks_from"); from.exists())
    rig.landmarks_from = provenance_of(from);
  const auto registration = [&](const char* key,
                                const std::optional<CameraCalibration>& camera) -> Eigen::MatrixXd {
    const auto joint = file->table(key);
    if (!joint.exists()) return {};
    const auto kind = camera ? camera->model.kind : device::LensKind::brown;
    const auto size = static_cast<std::size_t>(filed_lens_parameters(kind)) + 6 + 3 * rig.landmarks.size();
    return with_all_parameters(covariance_of(joint, "covariance_si", size, 1.0), kind);
  };
  rig.registration_covariance = registration("registration", rig.camera);
  rig.right_registration_covariance = registration("right_registration", rig.right_camera);
  if (const auto done = file->finish(); !done) return tl::unexpected(done.error());
  return rig;
}

Expected<Rig> read_rig(const std::filesystem::path& path) {
  if (path != "-" && !is_there(path))
    return wrong_use(
        "{}: no such file; a rig file is expected: `palpate demo` writes palpate-report/rig.toml, `palpate "
        "rig webcam` one of a desk, `palpate rig new` an empty one",
        path.string());
  const auto content = read_file(path, kMostSettingsBytes);
  if (!content) return tl::unexpected(content.error());
  auto rig = parse_rig(*content, path.string());
  if (rig) rig->folder = path.parent_path();
  return rig;
}

Expected<void> write_rig(const std::filesystem::path& path, const Rig& rig) {
  const std::string text = rig_text(rig);
  // Read back first: what this program could not read again never replaces a good file.
  if (const auto again = parse_rig(text, path.string()); !again)
    return wrong_use("the rig is not written: {}", again.error().message);
  return write_file(path, text);
}

}  // namespace palpate::rig
