#include "palpate/system/demo.h"

#include "palpate/applications/pingpong/pingpong.h"
#include "palpate/compositor/picture_file.h"
#include "palpate/core/progress.h"
#include "palpate/core/units.h"
#include "palpate/physics_server/physics_server.h"
#include "palpate/report/demo_report.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/system/applications.h"
#include "palpate/system/demo_raw.h"
#include "palpate/system/picture_book.h"
#include "palpate/system/picture_parts.h"
#include "palpate/system/realtime_leg.h"
#include "palpate/system/scene_settings.h"
#include "palpate/system/world_sample.h"

namespace palpate {
namespace {

enum PhaseIndex : std::size_t { kCalibrating, kPlaying, kRealtime, kWriting };

Rig blank_rig(const sim::WorldFile& world) {
  Rig rig;
  rig.name = "simulated rig";
  rig.nominal_lengths = {world.arm.lengths[0], world.arm.lengths[1]};
  rig.tip_marker_leds = world.tip_marker.leds;
  rig.camera_marker_leds = world.camera_marker.leds;
  rig.pointer_leds = world.pointer.leds;
  return rig;
}

CalibrationPlan plan_for(const DemoOptions& options) {
  CalibrationPlan plan;
  if (options.quick) {
    plan.board_s = 6.0;
    plan.board_every = 3;
    plan.lens_views = 20;
    plan.look_s = 2.0;
  }
  // A simulated laboratory has no calendar: the same run gives the same file, on whatever day.
  plan.date = "1970-01-01T00:00:00Z";
  return plan;
}

// Grid points of the true surfaces and where the calibrated rectangles say they are.
std::vector<CheckPoint> check_points(const sim::Truth& truth, const Rig& rig) {
  std::vector<CheckPoint> points;
  for (const auto& [name, corners] : {std::pair{"table", &truth.table}, std::pair{"wall", &truth.wall}}) {
    const auto* surface = rig.surface(name);
    if (surface == nullptr) continue;
    const Vector3 x = (*corners)[1] - (*corners)[0], y = (*corners)[3] - (*corners)[0];
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 4; ++j) {
        const double u = 0.1 + 0.2 * i, v = 0.125 + 0.25 * j;
        points.push_back(
            {(*corners)[0] + u * x + v * y,
             (surface->X_world_rectangle * Point<Rectangle>{{u * surface->width, v * surface->height, 0.0}})
                 .m});
      }
  }
  return points;
}

FrameErrors errors_of(const PlayedFrame& frame, const CameraModel& lens, const SceneDescription& scene,
                      const std::vector<CheckPoint>& points) {
  FrameErrors errors;
  const auto& record = frame.record;
  const CameraView drawn{lens, record.X_world_camera}, tracker{lens, record.X_world_camera_tracker};
  ErrorSummary world, world_tracker;
  for (const auto& point : points) {
    if (const auto e = overlay_error(drawn, point.estimate, frame.truth, point.truth)) world.add(*e);
    if (record.pose_source == PoseSource::none) continue;
    if (const auto e = overlay_error(tracker, point.estimate, frame.truth, point.truth))
      world_tracker.add(*e);
  }
  if (!world.empty()) errors.world_px = world.rms();
  if (!world_tracker.empty()) errors.world_px_tracker = world_tracker.rms();
  errors.tip_px = overlay_error(drawn, shown_tip(record.state, scene), frame.truth, frame.true_tip);
  return errors;
}

struct Overlay {
  ErrorSummary world, world_tracker, tip;
};

Overlay overlay_of(const LockstepResult& play, const CameraModel& lens, const SceneDescription& scene,
                   const std::vector<CheckPoint>& points) {
  Overlay all;
  for (const auto& frame : play.frames) {
    const CameraView drawn{lens, frame.record.X_world_camera},
        tracker{lens, frame.record.X_world_camera_tracker};
    for (const auto& point : points) {
      if (const auto e = overlay_error(drawn, point.estimate, frame.truth, point.truth)) all.world.add(*e);
      if (frame.record.pose_source == PoseSource::none) continue;
      if (const auto e = overlay_error(tracker, point.estimate, frame.truth, point.truth))
        all.world_tracker.add(*e);
    }
    if (const auto e =
            overlay_error(drawn, shown_tip(frame.record.state, scene), frame.truth, frame.true_tip))
      all.tip.add(*e);
  }
  return all;
}

double mm(double metres) { return mm_from_metres(metres); }

Json arm_json(const std::vector<MethodErrors>& methods, const std::vector<MethodErrors>& with_true_tip,
              std::size_t samples) {
  Json json;
  const auto& joint = methods.back();
  json["error_to_truth_mean_mm"] = mm(joint.error_to_truth_mean);
  json["heldout_mean_mm"] = mm(joint.held_out_mean);
  json["uncorrected_mean_mm"] = mm(methods.front().held_out_mean);
  const auto put = [&json](const std::string& prefix, const std::vector<MethodErrors>& list) {
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

}  // namespace

Expected<Json> run_demo(const DemoOptions& options) {
  for (const auto& folder : {options.out, options.out / "raw", options.out / "pictures"})
    if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  // What an earlier demo left must not be taken for this one's.
  std::error_code ignored;
  for (const auto& old :
       {options.out / "summary.json", options.out / "report.html", options.out / "video.mp4"})
    std::filesystem::remove(old, ignored);
  for (const auto& old : std::filesystem::directory_iterator(options.out / "pictures", ignored))
    if (old.path().extension() == ".png") std::filesystem::remove(old.path(), ignored);

  Progress progress({{"calibrating", options.quick ? 8.0 : 20.0},
                     {"playing", 1.5 * options.seconds},
                     {"playing in real time", options.realtime_s + 2.0},
                     {"writing the report", 2.0}});
  progress.begin(kCalibrating);

  // The renderer outlives the world, which holds on to it.
  sim::CameraRenderer renderer;
  const sim::RenderView render = [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
    renderer.render(view, rgb);
  };
  sim::SimWorld world(options.world, options.seed);
  world.set_renderer(render);

  Rig rig = blank_rig(options.world);
  const auto rig_path = options.out / "rig.toml";
  const CalibrationPlan plan = plan_for(options);
  SessionHooks hooks;
  hooks.progress = [&progress](std::size_t step, std::size_t steps, const std::string&) {
    progress.update(static_cast<double>(step) / static_cast<double>(steps));
  };
  hooks.save = [&rig_path](const Rig& so_far) { return write_rig(rig_path, so_far); };
  hooks.find_landmarks = landmark_finder();
  auto recordings = calibrate_rig(laboratory_of(world), rig, plan, hooks);
  if (!recordings) return tl::unexpected(recordings.error());

  const auto poses = judging_poses(options.world, options.seed);
  auto methods = compare_arm_methods(recordings->arm_train, recordings->arm_test, rig.nominal_lengths,
                                     rig.tip_pivot->tip_in_marker, world.truth(), poses);
  if (!methods) return tl::unexpected(methods.error());
  auto with_true_tip = compare_arm_methods(recordings->arm_train, recordings->arm_test, rig.nominal_lengths,
                                           world.truth().tip_in_marker, world.truth(), poses);
  if (!with_true_tip) return tl::unexpected(with_true_tip.error());

  // --- play in lock-step
  progress.begin(kPlaying);
  const auto scene = scene_from_rig(rig, scene_settings(options.world, options.application),
                                    options.world.ball.restitution_table);
  auto artist = make_artist(scene);
  if (!artist) return tl::unexpected(artist.error());
  PictureParts pictures(rig, scene, std::move(*artist));
  auto video = VideoFile::create(options.out / "video.mp4", rig.camera->model.width, rig.camera->model.height,
                                 options.world.camera.rate_hz);
  if (!video) return tl::unexpected(video.error());
  PictureBook book(options.out / "pictures", options.seconds, rig.camera->model, scene);
  Expected<void> shown;
  LockstepPictures parts;
  parts.camera = render;
  parts.refiner = pictures.refiner();
  parts.painter = pictures.painter();
  parts.shown = [&](const FrameRecord& frame) {
    video->add(frame.rgb);
    if (shown) shown = book.look(frame);
  };
  LockstepOptions lockstep;
  lockstep.seconds = options.seconds;
  lockstep.seed = options.seed;
  auto play = play_in_lockstep(world, rig, scene, lockstep, parts,
                               [&progress](double share) { progress.update(share); });
  if (!play) return tl::unexpected(play.error());
  if (!shown) return tl::unexpected(shown.error());
  if (auto closed = video->close(); !closed) return tl::unexpected(closed.error());
  if (play->frames.empty())
    return refused("demo: no frame was drawn in {:.0f} s; is the camera's latency longer than that?",
                   options.seconds);

  // --- raw data and summary
  const auto points = check_points(world.truth(), rig);
  std::vector<FrameErrors> frame_errors;
  for (const auto& frame : play->frames)
    frame_errors.push_back(errors_of(frame, rig.camera->model, scene, points));
  const Overlay overlay = overlay_of(*play, rig.camera->model, scene, points);
  if (auto done =
          write_calibration_raw(options.out / "raw", *recordings, rig, world.truth(), poses, *methods);
      !done)
    return tl::unexpected(done.error());
  if (auto done = write_play_raw(options.out / "raw", *play, scene, frame_errors, points, rig.camera->model,
                                 world.truth().lens);
      !done)
    return tl::unexpected(done.error());
  const auto world_path = options.out / "world.toml";
  if (auto done = write_file(world_path, sim::world_text(options.world)); !done)
    return tl::unexpected(done.error());

  Json summary;
  summary["seed"] = options.seed;
  summary["command"] = options.command;
  summary["seconds"] = options.seconds;
  summary["arm"] = arm_json(*methods, *with_true_tip, recordings->arm_train.size());
  summary["pivot"] = {
      {"error_to_truth_mm", mm((rig.tip_pivot->tip_in_marker - world.truth().tip_in_marker).norm())},
      {"stated_std_mm", mm(std::sqrt(rig.tip_pivot->covariance.trace()))},
      {"joint_error_to_truth_mm", mm((rig.arm->tip_in_marker - world.truth().tip_in_marker).norm())},
      {"poses", recordings->tip_pivot.size()}};
  summary["hand_eye"] = {
      {"error_to_truth_mm",
       mm((rig.hand_eye->X_marker_camera.translation - world.truth().X_marker_camera.translation).norm())},
      {"rotation_error_deg", degrees_from_radians(angle_between(rig.hand_eye->X_marker_camera.rotation,
                                                                world.truth().X_marker_camera.rotation))},
      {"images", recordings->eye.size()}};
  summary["camera"] = {{"rms_px", rig.camera->from.rms_mm}, {"views", recordings->lens_views.size()}};
  summary["delays"] = {
      {"tracker_after_arm_s", rig.delays->tracker_after_arm_s},
      {"tracker_after_arm_error_s", rig.delays->tracker_after_arm_s - options.world.tracker.latency_s},
      {"camera_after_tracker_s", rig.delays->camera_after_tracker_s},
      {"camera_after_tracker_error_s",
       rig.delays->camera_after_tracker_s -
           (options.world.camera.latency_s - options.world.tracker.latency_s)}};
  summary["registration"] = {{"world_px_rms", overlay.world.rms()},
                             {"world_px_p95", overlay.world.quantile(0.95)},
                             {"world_px_rms_tracker_only", overlay.world_tracker.rms()},
                             {"tip_px_rms", overlay.tip.rms()},
                             {"tip_px_p95", overlay.tip.quantile(0.95)},
                             {"check_points", points.size()},
                             {"landmark_px_rms_before", recordings->landmark_rms_px_before},
                             {"landmark_px_rms", recordings->landmark_rms_px}};
  Json answers = {{"exact", 0}, {"interpolated", 0}, {"extrapolated", 0}, {"too_old", 0}, {"too_new", 0}};
  int late = 0;
  for (const auto& frame : play->frames) {
    late += frame.record.late ? 1 : 0;
    answers[answer_name(frame.record.answer)] = answers[answer_name(frame.record.answer)].get<int>() + 1;
  }
  ErrorSummary sync;
  for (double e : play->sync_errors_s) sync.add(std::abs(e) * 1e6);
  summary["exchange"] = {{"frames", play->frames.size()},
                         {"late", late},
                         {"answers", answers},
                         {"lost", play->exchange.lost},
                         {"sync_error_us_p99", sync.quantile(0.99)}};
  const auto& counters = play->final_state.counters;
  summary["rally"] = {{"serves", counters[pingpong::kServes]},
                      {"returned", counters[pingpong::kReturned]},
                      {"longest", counters[pingpong::kLongest]},
                      {"hits", counters[pingpong::kHits]}};
  summary["force"] = {{"peak_n", play->haptic.peak_n},
                      {"limit_n", options.world.arm.max_force},
                      {"limited_ticks", play->haptic.limited_ticks},
                      {"fault_ticks", play->haptic.fault_ticks},
                      {"blows", play->haptic.blows},
                      {"lost_impulse_rel", play->haptic.lost_impulse_rel()},
                      {"impulse_error_rel_max", play->haptic.impulse_error_rel_max}};
  summary["player"] = {{"reaction_ms", options.world.player.reaction_s * 1e3},
                       {"aim_sd_mm", mm(options.world.player.aim_sd)},
                       {"max_hand_acceleration_m_s2", options.world.player.max_hand_acceleration},
                       {"sees", "the drawn pictures' states only"}};
  summary["pictures"] = book.captions();

  // --- the same in real time, as three processes
  if (!options.program.empty() && options.realtime_s > 0.0) {
    progress.begin(kRealtime);
    RealtimeLegOptions leg;
    leg.program = options.program;
    leg.rig = rig_path;
    leg.world = world_path;
    leg.out = options.out / "raw";
    leg.seed = options.seed;
    leg.seconds = options.realtime_s;
    leg.graphics_clock = options.world.clocks.graphics_host;
    auto realtime = run_realtime_leg(leg, [&progress](double share) { progress.update(share); });
    if (!realtime) return tl::unexpected(realtime.error());
    summary["realtime"] = *realtime;
  }

  progress.begin(kWriting);
  if (auto done = write_json(options.out / "summary.json", summary); !done)
    return tl::unexpected(done.error());
  if (auto done = report::write_demo_report(options.out); !done) return tl::unexpected(done.error());
  progress.finish();
  return summary;
}

std::vector<std::string> closing_lines(const Json& summary, const std::filesystem::path& out) {
  const auto number = [&summary](const char* part, const char* key) {
    return summary[part][key].get<double>();
  };
  std::vector<std::string> lines;
  lines.push_back(fmt::format(
      "arm:      {:.2f} mm before calibration, {:.3f} mm to the truth after (the paper's best way: {:.2f} "
      "mm)",
      number("arm", "uncorrected_mean_mm"), number("arm", "error_to_truth_mean_mm"),
      std::min({number("arm", "one_pass_error_to_truth_mm"), number("arm", "alternating_error_to_truth_mm"),
                number("arm", "eq7_error_to_truth_mm")})));
  lines.push_back(fmt::format("overlay:  table and wall {:.2f} px, stylus tip {:.2f} px rms",
                              number("registration", "world_px_rms"), number("registration", "tip_px_rms")));
  if (summary.contains("realtime")) {
    const auto& realtime = summary["realtime"];
    lines.push_back(
        fmt::format("exchange: {:.0f} us round trip, {} of {} frames late; clocks within {:.0f} us; haptic "
                    "loop {:.0f} Hz, {} overruns",
                    realtime["exchange"]["round_trip_us"]["median"].get<double>(),
                    realtime["exchange"]["late"].get<int>(), realtime["exchange"]["frames"].get<int>(),
                    realtime["sync"]["offset_error_us_p99"].get<double>(),
                    realtime["haptic"]["rate_hz"].get<double>(), realtime["haptic"]["overruns"].get<int>()));
  } else {
    lines.push_back(fmt::format("exchange: {} of {} frames late in lock-step; no real-time leg was run",
                                summary["exchange"]["late"].get<int>(),
                                summary["exchange"]["frames"].get<int>()));
  }
  lines.push_back(fmt::format("rally:    {} of {} serves returned, longest rally {}, peak force {:.1f} N",
                              summary["rally"]["returned"].get<int>(), summary["rally"]["serves"].get<int>(),
                              summary["rally"]["longest"].get<int>(), number("force", "peak_n")));
  lines.push_back(fmt::format("report:   {}", (out / "report.html").string()));
  return lines;
}

}  // namespace palpate
