// What a rig's file says, from the rig: the reading is in rig.cpp.
#include "palpate/core/toml.h"
#include "palpate/core/units.h"
#include "palpate/device/arm_model_file.h"
#include "palpate/rig/internal/filed_lens.h"
#include "palpate/rig/internal/number_text.h"
#include "palpate/rig/internal/rig_forces.h"
#include "palpate/rig/internal/rig_picture.h"
#include "palpate/rig/internal/rig_verifications.h"
#include "palpate/rig/internal/rig_version.h"
#include "palpate/rig/rig.h"

namespace palpate::rig {
namespace {

constexpr double kMm2PerM2 = 1.0 / ((1.0 / kMillimetresPerMetre) * (1.0 / kMillimetresPerMetre));

class Writer {
 public:
  void comment(std::string_view text) { text_ += fmt::format("# {}\n", text); }
  void lines(std::string_view text) { text_ += text; }
  void section(std::string_view name) { text_ += fmt::format("\n[{}]\n", name); }
  void item(std::string_view name) { text_ += fmt::format("\n[[{}]]\n", name); }
  void put(std::string_view key, const std::string& value) { text_ += fmt::format("{} = {}\n", key, value); }
  void number(std::string_view key, double value, double unit = 1.0) { put(key, number_text(value, unit)); }
  void text(std::string_view key, std::string_view value) { put(key, toml_quoted(value)); }
  void covariance(std::string_view key, const Eigen::MatrixXd& C) {
    if (C.size() > 0) put(key, number_rows(C));
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
  w.put("leds_mm", number_rows(m, kMillimetresPerMetre));
}

void write_pivot(Writer& w, const char* name, const std::optional<PivotCalibration>& pivot) {
  if (!pivot) return;
  w.section(name);
  w.put("tip_mm", number_list(pivot->tip_in_marker, kMillimetresPerMetre));
  w.put("covariance_mm2", number_rows(pivot->covariance, kMm2PerM2));
  w.provenance(pivot->from);
}

// What tells the kinematics, without a chain's joint tables.
void write_arm_model(Writer& w, const device::ArmModel& model) {
  if (model.kind == device::ArmModel::Kind::phantom) {
    w.put("lengths_mm",
          number_list(Eigen::Vector2d(model.lengths.l1, model.lengths.l2), kMillimetresPerMetre));
    return;
  }
  if (model.kind == device::ArmModel::Kind::cartesian) return w.lines(device::cartesian_text(model));
  w.text("type", "dh");
  w.lines(device::tool_text(model));
}

void write_nominal_arm(Writer& w, const device::ArmModel& model) {
  w.section("nominal_arm");
  if (model.kind != device::ArmModel::Kind::phantom) w.text("name", model.name);
  write_arm_model(w, model);
  w.lines(device::dh_joints_text(model, "nominal_arm.joint"));
}

void write_arm(Writer& w, const ArmCalibration& arm) {
  w.section("arm");
  w.text("model", arm.model.name);
  write_arm_model(w, arm.model);
  const bool cartesian = arm.model.kind == device::ArmModel::Kind::cartesian;
  if (!cartesian) {
    w.put("gains", number_list(arm.correction.gain));
    w.put("offsets_deg", number_list(arm.correction.offset, kDegreesPerRadian));
  }
  w.put("tip_mm", number_list(arm.tip_in_marker, kMillimetresPerMetre));
  w.put("marker_in_tip_qwxyz", number_list(arm.R_tip_marker));
  w.put("gimbal_gains", number_list(arm.gimbal_gain));
  w.put("gimbal_offsets_deg", number_list(arm.gimbal_offset, kDegreesPerRadian));
  if (arm.rest_known) {
    w.comment("Readings with the arm at rest: a start that reads otherwise has lost its zero.");
    const auto unit = device::reading_unit(arm.model);
    w.put(fmt::format("rest_readings_{}", unit.name), number_list(arm.rest_readings, unit.per_si));
  }
  w.number("held_out_mean_mm", arm.held_out_mean, kMillimetresPerMetre);
  w.provenance(arm.from);
  w.comment(fmt::format(
      "Order: gains {0}, offsets {0} (rad), base rotation 3 (rad), base translation 3 (m), tip 3 (m){1}.",
      arm.model.joint_count(),
      arm.model.kind == device::ArmModel::Kind::dh ? ", tool 3 (m)"
      : cartesian                                  ? ", correction 24 (m)"
                                                   : ""));
  w.covariance("covariance_si", arm.covariance);
  w.section("arm.base");
  w.put("rotation_qwxyz", number_list(arm.X_world_base.rotation));
  w.put("translation_mm", number_list(arm.X_world_base.translation, kMillimetresPerMetre));
  w.lines(device::dh_joints_text(arm.model, "arm.joint"));
}

void write_camera(Writer& w, std::string_view section, const CameraCalibration& camera) {
  w.section(section);
  const auto& m = camera.model;
  w.put("width_px", std::to_string(m.width));
  w.put("height_px", std::to_string(m.height));
  w.number("fx_px", m.fx), w.number("fy_px", m.fy), w.number("cx_px", m.cx), w.number("cy_px", m.cy);
  if (camera.encoding != device::Encoding::root) w.text("encoding", encoding_word(camera.encoding));
  if (m.kind != device::LensKind::brown) w.text("lens", device::lens_word(m.kind));
  w.comment(m.kind == device::LensKind::fisheye ? "Kannala-Brandt k1, k2, k3, k4, and 0"
            : m.kind == device::LensKind::rational
                ? "k1, k2, p1, p2, k3 above, k4, k5, k6 below, as OpenCV's rational model"
                : "Brown-Conrady k1, k2, p1, p2, k3");
  const auto count = static_cast<Eigen::Index>(filed_coefficients(m.kind));
  w.put("distortion", number_list(Eigen::Map<const Eigen::VectorXd>(m.distortion.data(), count)));
  w.provenance(camera.from, "rms_px");
  w.comment(fmt::format("Order: fx fy cx cy (px) {}{}.", device::coefficient_names(m.kind),
                        m.kind == device::LensKind::fisheye ? ", and zeros" : ""));
  w.covariance("covariance", filed_covariance(camera.covariance, m.kind));
}

void write_hand_eye(Writer& w, std::string_view section, const HandEyeCalibration& hand_eye) {
  w.section(section);
  w.put("rotation_qwxyz", number_list(hand_eye.X_marker_camera.rotation));
  w.put("translation_mm", number_list(hand_eye.X_marker_camera.translation, kMillimetresPerMetre));
  w.provenance(hand_eye.from);
  w.comment("Order: rotation 3 (rad), translation 3 (m), CameraMarker axes.");
  w.put("covariance_si", number_rows(hand_eye.covariance));
}

void write_headset(Writer& w, const HeadsetCalibration& headset) {
  w.section("headset");
  w.comment("The camera in the frame between the eyes: x right, y up, z backwards.");
  w.put("rotation_qwxyz", number_list(headset.X_eyes_camera.rotation));
  w.put("translation_mm", number_list(headset.X_eyes_camera.translation, kMillimetresPerMetre));
  w.number("delay_s", headset.delay_s);
  w.number("delay_std_s", headset.delay_std_s);
  w.provenance(headset.from);
  w.comment("Order: rotation 3 (rad), translation 3 (m), axes of that frame.");
  w.put("covariance_si", number_rows(headset.covariance));
}

}  // namespace

std::string rig_text(const Rig& rig) {
  Writer w;
  w.comment(
      "Rig file: what is known about one set of devices. Written by palpate; may be edited. Units are in the "
      "keys.");
  w.comment("Covariances named _si are in rad and m; rotations are perturbed from the left.");
  w.put("rig_version", std::to_string(kRigVersion));
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
  if (rig.headset) write_headset(w, *rig.headset);
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
    w.put("corner_mm", number_list(surface.X_world_rectangle.translation, kMillimetresPerMetre));
    w.put("rotation_qwxyz", number_list(surface.X_world_rectangle.rotation));
    w.number("width_mm", surface.width, kMillimetresPerMetre);
    w.number("height_mm", surface.height, kMillimetresPerMetre);
    if (surface.covariance.size() > 0) {
      w.comment("Order: rotation 3 (rad, World axes), corner 3 (m), width, height (m).");
      w.put("covariance_si", number_rows(surface.covariance));
    }
    if (surface.touch.freedoms > 0.0) {
      w.comment("By how much the hand missed per axis, and how many independent residuals say so.");
      w.number("touch_sd_mm", surface.touch.sd, kMillimetresPerMetre);
      w.number("touch_freedoms", surface.touch.freedoms);
    }
    w.provenance(surface.from);
  }
  for (const auto& landmark : rig.landmarks) {
    w.item("landmark");
    w.put("place_mm", number_list(landmark.place.m, kMillimetresPerMetre));
    w.put("normal", number_list(landmark.normal));
    w.number("diameter_mm", landmark.diameter, kMillimetresPerMetre);
    w.put("covariance_mm2", number_rows(landmark.covariance, kMm2PerM2));
  }
  if (rig.registration_covariance.size() > 0) {
    w.section("registration");
    const auto kind = rig.camera ? rig.camera->model.kind : device::LensKind::brown;
    w.comment(
        fmt::format("Of lens {}, hand-eye 6 and each landmark's place 3 together, in the units of their own.",
                    filed_lens_parameters(kind)));
    w.comment("Holds as long as theirs agree with it.");
    w.put("covariance_si", number_rows(filed_covariance(rig.registration_covariance, kind)));
  }
  if (rig.right_registration_covariance.size() > 0) {
    w.section("right_registration");
    const auto kind = rig.right_camera ? rig.right_camera->model.kind : device::LensKind::brown;
    w.put("covariance_si", number_rows(filed_covariance(rig.right_registration_covariance, kind)));
  }
  return w.take() + forces_text(rig.forces) + picture_parts_text(rig) + verifications_text(rig.verifications);
}

}  // namespace palpate::rig
