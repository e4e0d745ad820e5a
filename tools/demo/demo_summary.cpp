#include "tools/demo/demo_summary.h"

#include <algorithm>
#include <cmath>

#include "palpate/core/lower_case.h"
#include "palpate/core/units.h"
#include "palpate/server/graphics/record_names.h"
#include "palpate/sim/lockstep/play_figures.h"
#include "tools/demo/demo_raw.h"

namespace palpate::tools::demo {
namespace {

double mm(double metres) { return mm_from_metres(metres); }

Json arm_json(const std::vector<evaluation::MethodErrors>& methods,
              const std::vector<evaluation::MethodErrors>& with_true_tip, std::size_t samples) {
  Json json;
  const auto& joint = methods.back();
  json["error_to_truth_mean_mm"] = mm(joint.error_to_truth_mean);
  json["heldout_mean_mm"] = mm(joint.held_out_mean);
  json["uncorrected_mean_mm"] = mm(methods.front().held_out_mean);
  const auto put = [&json](const std::string& prefix, const std::vector<evaluation::MethodErrors>& list) {
    for (const auto& method : list) {
      std::string key = method.method == "one-pass" ? "one_pass" : method.method;
      json[prefix + key + "_error_to_truth_mm"] = mm(method.error_to_truth_mean);
      json[prefix + key + "_heldout_mm"] = mm(method.held_out_mean);
    }
  };
  put("", methods);
  put("true_tip_", with_true_tip);
  json["samples"] = samples;
  return json;
}

// Mean angle between the stylus as it is and as the calibrated arm and gimbal say, over readings that they
// have not seen.
double stylus_error(const rig::ArmCalibration& arm, const sim::Truth& truth,
                    const std::vector<device::ArmObservation>& unseen) {
  double sum = 0.0;
  for (const auto& sample : unseen) {
    const Vector3 gimbal = arm.gimbal_gain.cwiseProduct(*sample.gimbal) + arm.gimbal_offset;
    sum += angle_between(
        arm.X_world_base.rotation * device::phantom_stylus(arm.correction.apply(sample.joints), gimbal),
        truth.X_world_base.rotation *
            device::phantom_stylus(truth.joints.apply(sample.joints), truth.gimbal.apply(*sample.gimbal)));
  }
  return sum / static_cast<double>(unseen.size());
}

Json overlay_json(const evaluation::OverlayOfPlay& overlay,
                  const calibration::session::CameraRecordings& recordings) {
  // Promised, also where nothing was in view.
  Json json = {{"world_px_rms", 0.0},
               {"world_px_p95", 0.0},
               {"world_px_rms_tracker_only", 0.0},
               {"tip_px_rms", 0.0},
               {"tip_px_p95", 0.0},
               {"landmark_px_rms_before", recordings.landmark_rms_px_before},
               {"landmark_px_rms", recordings.landmark_rms_px}};
  json.update(evaluation::overlay_figures(overlay));
  return json;
}

// As keys have it, in lower case.
std::string name_of_first_body(const scene::SceneDescription& scene) {
  const auto name = scene.bodies.empty() ? "" : lower_case(scene.bodies.front().name);
  return name.empty() ? "body" : name;
}

Json calibrated_arm_json(const DemoOutcome& outcome) {
  const auto& recordings = outcome.recordings;
  Json json = arm_json(outcome.methods, outcome.with_true_tip, recordings.arm_train.size());
  json["stylus_error_to_truth_deg"] =
      degrees_from_radians(stylus_error(*outcome.rig.arm, outcome.truth, recordings.arm_test));
  if (!recordings.arm_predicted.empty() && !recordings.arm_predicted_random.empty()) {
    json["predicted_error_mm"] = mm(recordings.arm_predicted.back());
    json["predicted_error_unguided_mm"] = mm(recordings.arm_predicted_random.back());
  }
  return json;
}

Json pivot_json(const rig::Rig& rig, const sim::Truth& truth, std::size_t poses) {
  return {{"error_to_truth_mm", mm((rig.tip_pivot->tip_in_marker - truth.tip_in_marker).norm())},
          {"stated_std_mm", mm(std::sqrt(rig.tip_pivot->covariance.trace()))},
          {"joint_error_to_truth_mm", mm((rig.arm->tip_in_marker - truth.tip_in_marker).norm())},
          {"poses", poses}};
}

Json hand_eye_json(const rig::Rig& rig, const sim::Truth& truth, std::size_t images) {
  const auto &found = rig.hand_eye->X_marker_camera, &true_one = truth.X_marker_camera;
  return {{"error_to_truth_mm", mm((found.translation - true_one.translation).norm())},
          {"rotation_error_deg", degrees_from_radians(angle_between(found.rotation, true_one.rotation))},
          {"images", images}};
}

Json delays_json(const rig::DelayCalibration& found, const sim::config::WorldFile& world) {
  return {{"tracker_after_arm_s", found.tracker_after_arm_s},
          {"tracker_after_arm_error_s", found.tracker_after_arm_s - world.tracker.latency_s},
          {"camera_after_tracker_s", found.camera_after_tracker_s},
          {"camera_after_tracker_error_s",
           found.camera_after_tracker_s - (world.camera.latency_s - world.tracker.latency_s)}};
}

void add_right_eye(Json& registration, const DemoOutcome& outcome) {
  const StereoOverlay& stereo = *outcome.stereo;
  const std::string body = name_of_first_body(outcome.scene);
  registration["right_eye"] = overlay_json(stereo.right, outcome.recordings.right_camera);
  registration["right_eye"]["frames"] = stereo.right.frames.size();
  registration["disparity"] = {{"world_px_rms", stereo.disparity.world.rms()},
                               {"world_px_p95", stereo.disparity.world.quantile(0.95)},
                               {body + "_px_rms", stereo.disparity.body.rms()},
                               {body + "_px_p95", stereo.disparity.body.quantile(0.95)}};
}

Json registration_json(const DemoOutcome& outcome) {
  Json registration = overlay_json(outcome.overlay, outcome.recordings.camera);
  registration["check_points"] = outcome.check_points;
  if (outcome.stereo) add_right_eye(registration, outcome);
  Json sources = {{"none", 0}, {"tracker", 0}, {"refined", 0}, {"landmarks", 0}};
  double rejected = 0.0;
  const auto& frames = outcome.play.frames;
  for (const auto& frame : frames) {
    auto& count = sources[server::graphics::pose_source_name(frame.record.pose_source)];
    count = count.get<int>() + 1;
    rejected += frame.record.landmarks_rejected;
  }
  registration["pose_from"] = sources;
  registration["landmarks_rejected_per_frame"] =
      frames.empty() ? 0.0 : rejected / static_cast<double>(frames.size());
  return registration;
}

}  // namespace

Expected<Json> demo_summary(const DemoOutcome& outcome) {
  const auto& [options, truth, rig, recordings, methods, with_true_tip, play, overlay, stereo, points, scene,
               record] = outcome;
  Json summary;
  summary["seed"] = options.seed;
  summary["command"] = options.command;
  summary["application"] = options.application;
  summary["seconds"] = options.seconds;
  summary["arm"] = calibrated_arm_json(outcome);
  summary["pivot"] = pivot_json(rig, truth, recordings.tip_pivot.size());
  summary["hand_eye"] = hand_eye_json(rig, truth, recordings.camera.eye.size());
  summary["camera"] = {{"rms_px", rig.camera->from.rms_mm}, {"views", recordings.camera.lens_views.size()}};
  summary["delays"] = delays_json(*rig.delays, options.world);
  summary["registration"] = registration_json(outcome);
  summary["exchange"] = sim::lockstep::exchange_figures(play);
  Json rest;
  rest["force"] = sim::lockstep::force_figures(play.haptic, options.world.arm.max_force);
  rest["player"] = sim::lockstep::player_figures(options.world);
  const Json of_the_play = record.summary();
  for (const auto& [key, part] : of_the_play.items()) {
    if (summary.contains(key) || rest.contains(key) || key == "pictures" || key == "realtime" ||
        key == "made")
      return refused("{}: its summary has the key '{}', which is the system's", scene.application, key);
    summary[key] = part;
  }
  summary.update(rest);
  return summary;
}

std::vector<scene::ClosingLine> own_game(const Json& summary, const scene::PlayRecord& record) {
  const Json realtime = summary.value("realtime", Json::object());
  if (!realtime.contains("play") || !realtime.value("/window/played_by_mouse"_json_pointer, false)) return {};
  Json of_the_person = summary;
  of_the_person.update(realtime["play"]);
  of_the_person.erase("force");  // the server's are of all who played
  return record.closing_lines(of_the_person);
}

std::vector<std::string> closing_lines(const Json& summary,
                                       const std::vector<scene::ClosingLine>& of_the_play,
                                       const Json& verdicts, const std::filesystem::path& out) {
  const auto number = [&summary](const char* part, const char* key) {
    return summary[part][key].get<double>();
  };
  std::vector<std::string> lines;
  lines.push_back(fmt::format(
      "arm:      the tip {:.2f} mm from the truth before calibration, {:.3f} mm after (the paper's best way: "
      "{:.2f} mm)",
      number("arm", "uncorrected_error_to_truth_mm"), number("arm", "error_to_truth_mean_mm"),
      std::min({number("arm", "one_pass_error_to_truth_mm"), number("arm", "alternating_error_to_truth_mm"),
                number("arm", "eq7_error_to_truth_mm")})));
  lines.push_back(fmt::format("overlay:  table and wall {:.2f} px, stylus tip {:.2f} px rms",
                              number("registration", "world_px_rms"), number("registration", "tip_px_rms")));
  if (summary["registration"].contains("right_eye")) {
    const auto& right = summary["registration"]["right_eye"];
    lines.back() += fmt::format("; right eye {:.2f} and {:.2f}", right["world_px_rms"].get<double>(),
                                right["tip_px_rms"].get<double>());
  }
  if (summary.contains("realtime")) {
    const auto& realtime = summary["realtime"];
    lines.push_back(
        fmt::format("exchange: {:.0f} us round trip, {} of {} frames late; clocks within {:.0f} us; haptic "
                    "loop {:.0f} of 1000 Hz, {} overruns",
                    realtime["exchange"]["round_trip_us"]["median"].get<double>(),
                    realtime["exchange"]["late"].get<int>(), realtime["exchange"]["frames"].get<int>(),
                    realtime["sync"]["offset_error_us_p99"].get<double>(),
                    realtime["haptic"]["rate_hz"].get<double>(), realtime["haptic"]["overruns"].get<int>()));
  } else {
    lines.push_back(fmt::format("exchange: {} of {} frames late in lock-step; nothing was run in real time",
                                summary["exchange"]["late"].get<int>(),
                                summary["exchange"]["frames"].get<int>()));
  }
  if (summary.contains("realtime") && summary["realtime"].contains("network")) {
    const auto& network = summary["realtime"]["network"];
    const auto after = [&network](const char* key) {
      return network.contains(key) ? fmt::format("after {:.2f} s", network[key].get<double>()) : "never";
    };
    lines.push_back(
        fmt::format("network:  two hosts, {}; cable out for {:.1f} s: noticed {}, replies again {}",
                    network["encrypted"].get<bool>() ? "encrypted" : "not encrypted",
                    network["cut_for_s"].get<double>(), after("gone_after_s"), after("replies_after_s")));
  }
  const Json own = summary.value("/realtime/own_game"_json_pointer, Json::array());
  for (const auto& text : own) lines.push_back("you:      " + text.get<std::string>());
  for (const auto& line : of_the_play)
    lines.push_back(own.empty() ? fmt::format("{:<9} {}", line.about + ":", line.text)
                                : fmt::format("program:  {}, in lock-step", line.text));
  if (of_the_play.empty())  // an application that says nothing of a play: what the hand felt at least
    lines.push_back(fmt::format("force:    {:.2f} N at most, of the {:g} N that the arm may give",
                                number("force", "peak_n"), number("force", "limit_n")));
  for (const auto& one : verdicts.value("short", Json::array()))
    lines.push_back("falls short: " + one["words"].get<std::string>());
  lines.push_back(fmt::format("report:   {}", (out / "report.html").string()));
  return lines;
}

}  // namespace palpate::tools::demo
