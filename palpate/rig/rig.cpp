#include "palpate/rig/rig.h"

#include <ctime>
#include <set>

#include "palpate/core/file.h"
#include "palpate/core/toml.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_kinematics.h"
#include "palpate/device/arm_model_file.h"
#include "palpate/rig/file_mixup.h"
#include "palpate/rig/internal/rig_forces.h"
#include "palpate/rig/internal/rig_picture.h"

namespace palpate::rig {
namespace {

constexpr int kVersion = 1;
constexpr std::size_t kLensUnknowns = 9, kSurfaceUnknowns = 8;
constexpr NumberRange kLensFocus{1.0, 1e6}, kGain{0.5, 2.0}, kAngleDeg{-720.0, 720.0}, kPlaceMm{-1e5, 1e5},
    kLengthMm{1.0, 1e5};

// --- reading

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
  for (const auto& row : rows) leds.push_back(Vector3(row[0], row[1], row[2]) / kMillimetresPerMetre);
  if (!rows.empty() && rows.size() < 3)
    table.complain("leds_mm", fmt::format("has {} LEDs, at least 3 are needed for a pose", rows.size()));
  return leds;
}

constexpr double kMm = 1.0 / kMillimetresPerMetre, kMm2 = kMm * kMm;

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

// Of [nominal_arm] or [arm]: a PHANToM's lengths, or a chain (type = "dh").
device::ArmModel arm_model_of(const TomlTable& table, std::string_view name_key) {
  device::ArmModel model;
  table.expect("type");
  if (table.has("type") && table.choice("type", {"dh", "phantom"}) == "dh") {
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
  arm.correction.gain = joints_of(table, "gains", joints, 1.0, kGain);
  arm.correction.offset = joints_of(table, "offsets_deg", joints, 1.0 / kDegreesPerRadian, kAngleDeg);
  const auto base = table.table("base");
  arm.X_world_base = {rotation_of(base, "rotation_qwxyz"), vector_of(base, "translation_mm", kMm, kPlaceMm)};
  arm.tip_in_marker = vector_of(table, "tip_mm", kMm, kPlaceMm);
  arm.R_tip_marker = rotation_of(table, "marker_in_tip_qwxyz");
  arm.gimbal_gain = vector_of(table, "gimbal_gains", 1.0, kGain);
  arm.gimbal_offset = vector_of(table, "gimbal_offsets_deg", 1.0 / kDegreesPerRadian, kAngleDeg);
  arm.covariance = optional_covariance_of(table, "covariance_si", covariance_order(arm.model).size());
  arm.rest_readings = joints_of(table, "rest_readings_deg", joints, 1.0 / kDegreesPerRadian, kAngleDeg);
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
  m.distortion = table.numbers<5>("distortion", {-1e4, 1e4});
  camera.covariance = optional_covariance_of(table, "covariance", kLensUnknowns);
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

// --- writing

std::string list(const Eigen::Ref<const Eigen::VectorXd>& v, double unit = 1.0) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < v.size(); ++i) text += (i > 0 ? ", " : "") + toml_number(unit * v[i]);
  return text + "]";
}

std::string list(const Quaternion& q) { return list(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z())); }

std::string rows(const Eigen::MatrixXd& m, double unit = 1.0) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    text += (i > 0 ? ",\n  " : "\n  ") + list(m.row(i).transpose(), unit);
  return text + "\n]";
}

class Writer {
 public:
  void comment(std::string_view text) { text_ += fmt::format("# {}\n", text); }
  void lines(std::string_view text) { text_ += text; }
  void section(std::string_view name) { text_ += fmt::format("\n[{}]\n", name); }
  void item(std::string_view name) { text_ += fmt::format("\n[[{}]]\n", name); }
  void put(std::string_view key, const std::string& value) { text_ += fmt::format("{} = {}\n", key, value); }
  void number(std::string_view key, double value) { put(key, toml_number(value)); }
  void text(std::string_view key, std::string_view value) { put(key, toml_quoted(value)); }
  void covariance(std::string_view key, const Eigen::MatrixXd& C) {
    if (C.size() > 0) put(key, rows(C));
  }
  void provenance(const Provenance& from, std::string_view rms_key = "rms_mm") {
    if (!from.date.empty()) text("date", from.date);
    if (!from.data_hash.empty()) text("data_hash", from.data_hash);
    if (!from.method.empty()) text("method", from.method);
    number(rms_key, from.rms_mm);
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

void write_leds(Writer& w, const char* name, const std::vector<Vector3>& leds) {
  if (leds.empty()) return;
  w.section(name);
  Eigen::MatrixXd m(static_cast<Eigen::Index>(leds.size()), 3);
  for (Eigen::Index i = 0; i < m.rows(); ++i) m.row(i) = leds[static_cast<std::size_t>(i)];
  w.put("leds_mm", rows(m, kMillimetresPerMetre));
}

void write_pivot(Writer& w, const char* name, const std::optional<PivotCalibration>& pivot) {
  if (!pivot) return;
  w.section(name);
  w.put("tip_mm", list(pivot->tip_in_marker, kMillimetresPerMetre));
  w.put("covariance_mm2", rows(pivot->covariance, 1 / kMm2));
  w.provenance(pivot->from);
}

// What tells the kinematics, without a chain's joint tables.
void write_arm_model(Writer& w, const device::ArmModel& model) {
  if (model.kind == device::ArmModel::Kind::phantom) {
    w.put("lengths_mm", list(Eigen::Vector2d(model.lengths.l1, model.lengths.l2), kMillimetresPerMetre));
    return;
  }
  w.text("type", "dh");
  w.lines(device::tool_text(model));
}

void write_nominal_arm(Writer& w, const device::ArmModel& model) {
  w.section("nominal_arm");
  if (model.kind == device::ArmModel::Kind::dh) w.text("name", model.name);
  write_arm_model(w, model);
  w.lines(device::dh_joints_text(model, "nominal_arm.joint"));
}

void write_arm(Writer& w, const ArmCalibration& arm) {
  w.section("arm");
  w.text("model", arm.model.name);
  write_arm_model(w, arm.model);
  w.put("gains", list(arm.correction.gain));
  w.put("offsets_deg", list(arm.correction.offset, kDegreesPerRadian));
  w.put("tip_mm", list(arm.tip_in_marker, kMillimetresPerMetre));
  w.put("marker_in_tip_qwxyz", list(arm.R_tip_marker));
  w.put("gimbal_gains", list(arm.gimbal_gain));
  w.put("gimbal_offsets_deg", list(arm.gimbal_offset, kDegreesPerRadian));
  w.comment("Encoder readings with the arm at rest: a start that reads otherwise has lost its zero.");
  w.put("rest_readings_deg", list(arm.rest_readings, kDegreesPerRadian));
  w.number("held_out_mean_mm", kMillimetresPerMetre * arm.held_out_mean);
  w.provenance(arm.from);
  w.comment(fmt::format(
      "Order: gains {0}, offsets {0} (rad), base rotation 3 (rad), base translation 3 (m), tip 3 (m){1}.",
      arm.model.joint_count(), arm.model.kind == device::ArmModel::Kind::dh ? ", tool 3 (m)" : ""));
  w.covariance("covariance_si", arm.covariance);
  w.section("arm.base");
  w.put("rotation_qwxyz", list(arm.X_world_base.rotation));
  w.put("translation_mm", list(arm.X_world_base.translation, kMillimetresPerMetre));
  w.lines(device::dh_joints_text(arm.model, "arm.joint"));
}

void write_camera(Writer& w, std::string_view section, const CameraCalibration& camera) {
  w.section(section);
  const auto& m = camera.model;
  w.put("width_px", std::to_string(m.width));
  w.put("height_px", std::to_string(m.height));
  w.number("fx_px", m.fx), w.number("fy_px", m.fy), w.number("cx_px", m.cx), w.number("cy_px", m.cy);
  if (camera.encoding != device::Encoding::root) w.text("encoding", encoding_word(camera.encoding));
  w.comment("Brown-Conrady k1, k2, p1, p2, k3");
  w.put("distortion", list(Eigen::Map<const Eigen::VectorXd>(m.distortion.data(), 5)));
  w.provenance(camera.from, "rms_px");
  w.comment("Order: fx fy cx cy (px) k1 k2 p1 p2 k3.");
  w.covariance("covariance", camera.covariance);
}

void write_hand_eye(Writer& w, std::string_view section, const HandEyeCalibration& hand_eye) {
  w.section(section);
  w.put("rotation_qwxyz", list(hand_eye.X_marker_camera.rotation));
  w.put("translation_mm", list(hand_eye.X_marker_camera.translation, kMillimetresPerMetre));
  w.provenance(hand_eye.from);
  w.comment("Order: rotation 3 (rad), translation 3 (m), CameraMarker axes.");
  w.put("covariance_si", rows(hand_eye.covariance));
}

}  // namespace

Expected<Rig> parse_rig(std::string_view content, const std::string& source) {
  const auto file = parse_toml(content, source);
  if (!file) return tl::unexpected(file.error());
  if (auto fine = is_no_world_file(*file, source); !fine) return tl::unexpected(fine.error());
  Rig rig;
  if (const auto version = file->integer("rig_version", {1, kVersion});
      version != kVersion && file->has("rig_version"))
    file->complain("rig_version", fmt::format("is {}, this program reads {}", version, kVersion));
  rig.name = file->text_or("name", rig.name);
  const auto nominal = file->table("nominal_arm");
  if (nominal.exists()) rig.nominal_arm = arm_model_of(nominal, "name");
  rig.tip_marker_leds = leds_of(file->table("tip_marker"));
  rig.camera_marker_leds = leds_of(file->table("camera_marker"));
  rig.pointer_leds = leds_of(file->table("pointer"));
  rig.tip_pivot = pivot_of(file->table("tip_pivot"));
  rig.pointer_pivot = pivot_of(file->table("pointer_pivot"));
  rig.arm = arm_of(file->table("arm"));
  if (rig.arm && !nominal.exists() && rig.arm->model.kind == device::ArmModel::Kind::dh)
    rig.nominal_arm = rig.arm->model;
  if (rig.arm && rig.arm->model.joint_count() != rig.nominal_arm.joint_count())
    file->complain("arm", fmt::format("has {} joints, nominal_arm has {}; the same arm is expected",
                                      rig.arm->model.joint_count(), rig.nominal_arm.joint_count()));
  rig.forces = forces_of(file->table("forces"));
  rig.camera = camera_of(file->table("camera"));
  rig.hand_eye = hand_eye_of(file->table("hand_eye"));
  rig.right_camera = camera_of(file->table("right_camera"));
  rig.right_hand_eye = hand_eye_of(file->table("right_hand_eye"));
  read_picture_parts(*file, rig);
  rig.delays = delays_of(file->table("delays"));
  std::set<std::string> names;
  for (const auto& table : file->tables("surface")) rig.surfaces.push_back(surface_of(table, names));
  for (const auto& table : file->tables("landmark")) rig.landmarks.push_back(landmark_of(table));
  if (const auto from = file->table("landmarks_from"); from.exists())
    rig.landmarks_from = provenance_of(from);
  if (const auto joint = file->table("registration"); joint.exists())
    rig.registration_covariance =
        covariance_of(joint, "covariance_si", kLensUnknowns + 6 + 3 * rig.landmarks.size(), 1.0);
  if (const auto joint = file->table("right_registration"); joint.exists())
    rig.right_registration_covariance =
        covariance_of(joint, "covariance_si", kLensUnknowns + 6 + 3 * rig.landmarks.size(), 1.0);
  if (const auto done = file->finish(); !done) return tl::unexpected(done.error());
  return rig;
}

Expected<Rig> read_rig(const std::filesystem::path& path) {
  if (!is_there(path))
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

std::string rig_text(const Rig& rig) {
  Writer w;
  w.comment(
      "Rig file: what is known about one set of devices. Written by palpate; may be edited. Units are in the "
      "keys.");
  w.comment("Covariances named _si are in rad and m; rotations are perturbed from the left.");
  w.put("rig_version", std::to_string(kVersion));
  w.text("name", rig.name);
  write_nominal_arm(w, rig.nominal_arm);
  write_leds(w, "tip_marker", rig.tip_marker_leds);
  write_leds(w, "camera_marker", rig.camera_marker_leds);
  write_leds(w, "pointer", rig.pointer_leds);
  write_pivot(w, "tip_pivot", rig.tip_pivot);
  write_pivot(w, "pointer_pivot", rig.pointer_pivot);
  if (rig.arm) write_arm(w, *rig.arm);
  if (rig.camera) write_camera(w, "camera", *rig.camera);
  if (rig.hand_eye) write_hand_eye(w, "hand_eye", *rig.hand_eye);
  if (rig.right_camera) write_camera(w, "right_camera", *rig.right_camera);
  if (rig.right_hand_eye) write_hand_eye(w, "right_hand_eye", *rig.right_hand_eye);
  if (rig.delays) {
    w.section("delays");
    w.number("tracker_after_arm_s", rig.delays->tracker_after_arm_s);
    w.number("camera_after_tracker_s", rig.delays->camera_after_tracker_s);
    w.number("tracker_std_s", rig.delays->tracker_std_s);
    w.number("camera_std_s", rig.delays->camera_std_s);
    w.provenance(rig.delays->from);
  }
  if (const auto& from = rig.landmarks_from;
      !from.date.empty() || !from.method.empty() || !from.data_hash.empty() || from.rms_mm > 0) {
    w.section("landmarks_from");
    w.provenance(from);
  }
  for (const auto& surface : rig.surfaces) {
    w.item("surface");
    w.text("name", surface.name);
    w.put("corner_mm", list(surface.X_world_rectangle.translation, kMillimetresPerMetre));
    w.put("rotation_qwxyz", list(surface.X_world_rectangle.rotation));
    w.number("width_mm", kMillimetresPerMetre * surface.width);
    w.number("height_mm", kMillimetresPerMetre * surface.height);
    if (surface.covariance.size() > 0) {
      w.comment("Order: rotation 3 (rad, World axes), corner 3 (m), width, height (m).");
      w.put("covariance_si", rows(surface.covariance));
    }
    if (surface.touch.freedoms > 0.0) {
      w.comment("By how much the hand missed per axis, and how many independent residuals say so.");
      w.number("touch_sd_mm", kMillimetresPerMetre * surface.touch.sd);
      w.number("touch_freedoms", surface.touch.freedoms);
    }
    w.provenance(surface.from);
  }
  for (const auto& landmark : rig.landmarks) {
    w.item("landmark");
    w.put("place_mm", list(landmark.place.m, kMillimetresPerMetre));
    w.put("normal", list(landmark.normal));
    w.number("diameter_mm", kMillimetresPerMetre * landmark.diameter);
    w.put("covariance_mm2", rows(landmark.covariance, 1 / kMm2));
  }
  if (rig.registration_covariance.size() > 0) {
    w.section("registration");
    w.comment("Of lens 9, hand-eye 6 and each landmark's place 3 together, in the units of their own.");
    w.comment("Holds as long as theirs agree with it.");
    w.put("covariance_si", rows(rig.registration_covariance));
  }
  if (rig.right_registration_covariance.size() > 0) {
    w.section("right_registration");
    w.put("covariance_si", rows(rig.right_registration_covariance));
  }
  return w.take() + forces_text(rig.forces) + picture_parts_text(rig);
}

Expected<void> write_rig(const std::filesystem::path& path, const Rig& rig) {
  const std::string text = rig_text(rig);
  // Read back first: what this program could not read again never replaces a good file.
  if (const auto again = parse_rig(text, path.string()); !again)
    return wrong_use("the rig is not written: {}", again.error().message);
  return write_file(path, text);
}

}  // namespace palpate::rig
