#include "tools/demo/demo_raw.h"

#include "palpate/calibration/session/sample_csv.h"
#include "palpate/core/csv.h"
#include "palpate/core/units.h"
#include "palpate/math/csv_cells.h"
#include "palpate/server/graphics/record_names.h"
#include "palpate/sim/truth_json.h"

namespace palpate::tools::demo {
namespace {

Json list(const Vector3& v, double unit) { return {v.x() * unit, v.y() * unit, v.z() * unit}; }
Json wxyz(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

std::string lens_csv(const device::CameraModel& estimated, const device::CameraModel& truth) {
  CsvWriter csv({"which", "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "width", "height", "lens",
                 "k4", "k5", "k6"});
  for (const auto& [name, lens] : {std::pair{"est", &estimated}, std::pair{"true", &truth}}) {
    Cells row{name};
    for (double value : {lens->fx, lens->fy, lens->cx, lens->cy}) put(row, value);
    const std::span<const double> bend(lens->distortion);
    for (double value : bend.first(5)) put(row, value);
    put(row, static_cast<double>(lens->width));
    put(row, static_cast<double>(lens->height));
    row.push_back(device::lens_word(lens->kind));
    for (double value : bend.last(3)) put(row, value);
    csv.row(row);
  }
  return csv.content();
}

// Predicted error of the arm against the number of poses, as far as both orders go.
std::string guidance_csv(const calibration::session::CalibrationRecordings& recordings) {
  CsvWriter csv({"poses", "guided_mm", "chosen_mm"});
  for (std::size_t i = 0;
       i < std::min(recordings.arm_predicted.size(), recordings.arm_predicted_random.size()); ++i) {
    const double guided = recordings.arm_predicted[i], chosen = recordings.arm_predicted_random[i];
    if (std::isfinite(guided) && std::isfinite(chosen))
      csv.row(
          std::vector<double>{static_cast<double>(i + 1), mm_from_metres(guided), mm_from_metres(chosen)});
  }
  return csv.content();
}

}  // namespace

Json arm_result_json(const calibration::ArmSolution& arm) {
  Json json;
  json["gains"] = list(arm.gain.head<3>(), 1.0);
  json["offsets_deg"] = list(arm.offset.head<3>(), kDegreesPerRadian);
  json["lengths_mm"] = {mm_from_metres(arm.model.lengths.l1), mm_from_metres(arm.model.lengths.l2)};
  json["tip_mm"] = list(arm.tip_in_marker, kMillimetresPerMetre);
  json["base"] = {{"translation_mm", list(arm.X_world_base.translation, kMillimetresPerMetre)},
                  {"rotation_qwxyz", wxyz(arm.X_world_base.rotation)}};
  return json;
}

Expected<void> write_calibration_raw(const std::filesystem::path& raw,
                                     const calibration::session::CalibrationRecordings& recordings,
                                     const rig::Rig& rig, const sim::Truth& truth,
                                     const std::vector<Vector3>& poses,
                                     const std::vector<evaluation::MethodErrors>& methods) {
  const Vector3 tip = rig.tip_pivot->tip_in_marker;
  const auto split = recordings.arm_poses.begin() + static_cast<std::ptrdiff_t>(recordings.arm_train.size());
  Json estimates, truths;
  CsvWriter errors({"method", "pose", "error_mm", "x_mm", "y_mm", "z_mm", "dx_mm", "dy_mm", "dz_mm"});
  CsvWriter judged({"pose", "joint_1_deg", "joint_2_deg", "joint_3_deg"});
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Cells row{number_text(static_cast<double>(i))};
    put(row, Vector3(poses[i] * kDegreesPerRadian));
    judged.row(row);
  }
  for (const auto& method : methods) {
    if (method.method != "uncorrected") estimates["arm"][method.method] = arm_result_json(method.solution);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      Cells row{method.method, number_text(static_cast<double>(i)),
                number_text(mm_from_metres(method.errors[i]))};
      const Vector3 estimate = calibration::predict_tip(method.solution, poses[i]).m;
      put(row, Vector3((estimate - method.differences[i]) * kMillimetresPerMetre));
      put(row, Vector3(method.differences[i] * kMillimetresPerMetre));
      errors.row(row);
    }
  }
  estimates["gimbal"] = {{"gimbal_gains", list(rig.arm->gimbal_gain, 1.0)},
                         {"gimbal_offsets_deg", list(rig.arm->gimbal_offset, kDegreesPerRadian)}};
  estimates["pivot"] = {{"tip_mm", list(tip, kMillimetresPerMetre)}};
  estimates["hand_eye"] = {
      {"translation_mm", list(rig.hand_eye->X_marker_camera.translation, kMillimetresPerMetre)},
      {"rotation_qwxyz", wxyz(rig.hand_eye->X_marker_camera.rotation)}};
  truths["arm"] = sim::arm_truth_json(truth, 0.0);
  truths["pivot"] = {{"tip_mm", list(truth.tip_in_marker, kMillimetresPerMetre)}};
  truths["hand_eye"] = {{"translation_mm", list(truth.X_marker_camera.translation, kMillimetresPerMetre)},
                        {"rotation_qwxyz", wxyz(truth.X_marker_camera.rotation)}};

  std::vector<calibration::session::TouchedPoint> touched = recordings.corners;
  touched.insert(touched.end(), recordings.landmark_touches.begin(), recordings.landmark_touches.end());
  const std::vector<std::pair<std::string, std::string>> files{
      {"pivot.csv", calibration::session::pivot_csv(recordings.tip_pivot, true)},
      {"pointer_pivot.csv", calibration::session::pivot_csv(recordings.pointer_pivot, false)},
      {"arm_calibration.csv", calibration::session::arm_csv({recordings.arm_poses.begin(), split}, tip)},
      {"arm_held_out.csv", calibration::session::arm_csv({split, recordings.arm_poses.end()}, tip)},
      {"arm_poses.csv", judged.content()},
      {"arm_errors.csv", errors.content()},
      {"arm_guidance.csv", guidance_csv(recordings)},
      {"surface.csv", calibration::session::points_csv(recordings.corners)},
      {"touches.csv", calibration::session::points_csv(touched)},
      {"hand.csv", calibration::session::poses_csv(recordings.camera.hand)},
      {"eye.csv", calibration::session::poses_csv(recordings.camera.eye)},
      {"corners.csv", calibration::session::corners_csv(recordings.camera.lens_views)},
      {"estimates.json", estimates.dump(2) + "\n"},
      {"truth.json", truths.dump(2) + "\n"}};
  for (const auto& [name, content] : files)
    if (auto done = write_file(raw / name, content); !done) return done;
  return {};
}

Expected<void> write_eye_raw(const std::filesystem::path& raw, server::graphics::EyeSide side,
                             const sim::lockstep::LockstepResult& play,
                             const std::vector<evaluation::FrameErrors>& errors,
                             const device::CameraModel& estimated_lens,
                             const device::CameraModel& true_lens) {
  CsvWriter frames({"frame",           "mid_exposure_s",
                    "cam_x_m",         "cam_y_m",
                    "cam_z_m",         "cam_qw",
                    "cam_qx",          "cam_qy",
                    "cam_qz",          "tip_x_m",
                    "tip_y_m",         "tip_z_m",
                    "answer",          "late",
                    "world_px",        "tip_px",
                    "tracker_cam_x_m", "tracker_cam_y_m",
                    "tracker_cam_z_m", "tracker_cam_qw",
                    "tracker_cam_qx",  "tracker_cam_qy",
                    "tracker_cam_qz",  "landmarks_used",
                    "landmark_rms_px", "landmarks_rejected",
                    "pose_source",     "expected_world_px",
                    "landmark_misfit", "state_s"});
  CsvWriter truths({"frame", "cam_x_m", "cam_y_m", "cam_z_m", "cam_qw", "cam_qx", "cam_qy", "cam_qz",
                    "tip_x_m", "tip_y_m", "tip_z_m"});
  auto of_frame = errors.begin();
  for (const auto& frame : play.frames) {
    const auto& r = frame.record;
    if (side == server::graphics::EyeSide::right && !frame.right_truth) continue;
    const server::graphics::EyePose& eye = side == server::graphics::EyeSide::right ? *r.right : r;
    const evaluation::CameraView& truth =
        side == server::graphics::EyeSide::right ? *frame.right_truth : frame.truth;
    Cells row{number_text(static_cast<double>(r.number)), number_text(r.stamp.seconds())};
    put(row, eye.X_world_camera);
    put(row, frame.shown_tip);
    row.push_back(server::graphics::answer_name(r.answer));
    row.push_back(r.late ? "1" : "0");
    put(row, of_frame->world_px);
    put(row, of_frame->tip_px);
    ++of_frame;
    if (!eye.have_tracker)
      row.insert(row.end(), 7, "");
    else
      put(row, eye.X_world_camera_tracker);
    put(row, static_cast<double>(eye.landmarks_used));
    put(row, eye.landmark_rms_px);
    put(row, static_cast<double>(eye.landmarks_rejected));
    row.push_back(server::graphics::pose_source_name(eye.pose_source));
    put(row, eye.expected_world_px);
    put(row, eye.landmark_misfit);
    put(row, r.state.time.seconds());
    frames.row(row);

    Cells true_row{number_text(static_cast<double>(r.number))};
    put(true_row, truth.X_world_camera);
    put(true_row, frame.true_tip);
    truths.row(true_row);
  }
  const std::string ending = side == server::graphics::EyeSide::right ? "_right.csv" : ".csv";
  for (const auto& [name, content] :
       {std::pair{"frames", frames.content()}, std::pair{"truth_frames", truths.content()},
        std::pair{"lens", lens_csv(estimated_lens, true_lens)}})
    if (auto done = write_file(raw / (name + ending), content); !done) return done;
  return {};
}

Expected<void> write_play_raw(const std::filesystem::path& raw, const sim::lockstep::LockstepResult& play,
                              const std::vector<evaluation::CheckPoint>& points) {
  CsvWriter checks({"point", "true_x_m", "true_y_m", "true_z_m", "est_x_m", "est_y_m", "est_z_m"});
  for (std::size_t i = 0; i < points.size(); ++i) {
    Cells row{number_text(static_cast<double>(i))};
    put(row, points[i].truth);
    put(row, points[i].estimate);
    checks.row(row);
  }
  CsvWriter haptics({"time_s", "force_x_n", "force_y_n", "force_z_n", "asked_n", "given_n", "tip_x_m",
                     "tip_y_m", "tip_z_m"});
  for (const auto& record : play.haptics) {
    Cells row{number_text(record.time.seconds())};
    put(row, record.commanded);
    put(row, record.requested.norm());
    put(row, record.commanded.norm());
    put(row, record.tip);
    haptics.row(row);
  }
  for (const auto& [name, content] :
       {std::pair{"check_points.csv", checks.content()}, std::pair{"haptics.csv", haptics.content()}})
    if (auto done = write_file(raw / name, content); !done) return done;
  return {};
}

Expected<void> write_tables(const std::filesystem::path& raw, const scene::ApplicationSpec& application,
                            const scene::PlayRecord& record) {
  const auto contents = record.tables();
  if (contents.size() != application.tables.size())
    return refused("{}: its record has {} tables; {} were announced", application.name, contents.size(),
                   application.tables.size());
  for (std::size_t i = 0; i < contents.size(); ++i) {
    const auto& file = application.tables[i].file;
    if (std::filesystem::exists(raw / file))
      return refused("{}: its table '{}' has the name of one of the system's", application.name, file);
    if (auto done = write_file(raw / file, contents[i]); !done) return done;
  }
  return {};
}

}  // namespace palpate::tools::demo
