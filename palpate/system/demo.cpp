#include "palpate/system/demo.h"

#include <algorithm>

#include "palpate/applications/applications.h"
#include "palpate/applications/scene_settings.h"
#include "palpate/applications/touched_mesh.h"
#include "palpate/compositor/picture_file.h"
#include "palpate/core/progress.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/units.h"
#include "palpate/physics_server/physics_server.h"
#include "palpate/report/demo_report.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/system/demo_raw.h"
#include "palpate/system/demo_summary.h"
#include "palpate/system/picture_book.h"
#include "palpate/system/picture_parts.h"
#include "palpate/system/realtime_leg.h"
#include "palpate/system/touch_log.h"
#include "palpate/system/world_sample.h"

namespace palpate {
namespace {

// Thrown where the demo looks at Ctrl-C: on its way out the processes it started end and unfinished files go.
struct Interrupted {};

void go_on_unless_stopped() {
  if (stop_requested().load()) throw Interrupted{};
}

// Somebody at a desk does not turn the head twenty degrees and back every second; they move it a little,
// which is how depth is seen. And they begin with slow serves.
sim::WorldFile for_a_person(sim::WorldFile world) {
  world.head.turn_peak = std::min(world.head.turn_peak, radians_from_degrees(4.0));
  world.head.turn_hz = std::min(world.head.turn_hz, 0.15);
  world.head.shake = std::min(world.head.shake, radians_from_degrees(0.05));
  world.ball.serve_speed[1] = std::min(world.ball.serve_speed[1], std::max(2.3, world.ball.serve_speed[0]));
  return world;
}

CalibrationPlan plan_for(const DemoOptions& options) {
  CalibrationPlan plan;
  if (options.quick) {
    plan.board_s = 6.0;
    plan.board_every = 3;
    plan.lens_views = 20;
    plan.look_s = 2.0;
  }
  plan.reach = reach_of(options.world);
  plan.guidance_seed = options.seed;
  // A simulated laboratory has no calendar: the same run gives the same file, on whatever day.
  plan.date = "1970-01-01T00:00:00Z";
  return plan;
}

Expected<Json> demo(const DemoOptions& options) {
  // Known now, not after minutes of calibration.
  auto settings = scene_settings(options.world, options.application);
  if (auto mesh = read_touched_mesh(settings); !mesh) return tl::unexpected(mesh.error());
  if (options.two_hosts)
    if (auto possible = TwoHosts::make(); !possible) return tl::unexpected(possible.error());
  for (const auto& folder : {options.out, options.out / "raw", options.out / "pictures"})
    if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  // What an earlier demo left must not be taken for this one's.
  std::error_code ignored;
  for (const auto& old :
       {options.out / "summary.json", options.out / "report.html", options.out / "video.mp4",
        options.out / "raw" / "realtime_network.csv", options.out / "raw" / "realtime_photons.csv",
        options.out / "raw" / "realtime_truth.csv", options.out / "raw" / "realtime_poses.csv",
        options.out / "raw" / "ball.csv", options.out / "raw" / "touch.csv",
        options.out / "raw" / "frames_right.csv", options.out / "raw" / "truth_frames_right.csv",
        options.out / "raw" / "lens_right.csv"})
    std::filesystem::remove(old, ignored);
  for (const auto& old : std::filesystem::directory_iterator(options.out / "pictures", ignored))
    if (old.path().extension() == ".png") std::filesystem::remove(old.path(), ignored);

  std::vector<Progress::Phase> phases = {{"calibrating", options.quick ? 8.0 : 20.0},
                                         {"playing", 1.5 * options.seconds},
                                         {"playing in real time", options.realtime_s + 2.0},
                                         {"writing the report", 2.0}};
  // A person at the window comes first.
  const std::size_t playing = options.window ? 2 : 1, in_real_time = options.window ? 1 : 2;
  if (options.window) std::swap(phases[1], phases[2]);
  Progress progress(std::move(phases));
  progress.begin(0);
  const auto go_on = [&progress](double share) {
    go_on_unless_stopped();
    progress.update(share);
  };

  // The renderer outlives the world, which holds on to it.
  sim::CameraRenderer renderer;
  const sim::RenderView render = [&renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
    go_on_unless_stopped();
    renderer.render(view, rgb);
  };
  sim::SimWorld world(options.world, options.seed);
  world.set_renderer(render);

  Rig rig = blank_rig(options.world);
  const auto rig_path = options.out / "rig.toml";
  const CalibrationPlan plan = plan_for(options);
  SessionHooks hooks;
  hooks.progress = [&progress](std::size_t step, std::size_t steps, const std::string&) {
    go_on_unless_stopped();
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

  const auto world_path = options.out / "world.toml";
  if (auto done = write_file(world_path, sim::world_text(options.world)); !done)
    return tl::unexpected(done.error());

  // --- in real time, as three processes
  std::optional<Json> realtime;
  const auto play_in_real_time = [&]() -> Expected<void> {
    if (options.program.empty() || options.realtime_s <= 0.0) return {};
    progress.begin(in_real_time);
    RealtimeLegOptions leg;
    leg.program = options.program;
    leg.rig = rig_path;
    leg.application = options.application;
    leg.quality = options.quality;
    leg.world = world_path;
    leg.out = options.out / "raw";
    leg.seed = options.seed;
    leg.seconds = options.realtime_s;
    leg.two_hosts = options.two_hosts;
    leg.scan_out = seconds(options.world.display.scan_out_s);
    leg.graphics_clock = options.world.clocks.graphics_host;
    leg.window = options.window;
    leg.monitor = options.monitor;
    if (options.window) {
      leg.world = options.out / "world-window.toml";
      if (auto done = write_file(leg.world, sim::world_text(for_a_person(options.world))); !done) return done;
      if (options.notice)
        options.notice(
            "demo: the window opens; move the mouse in it to play, q ends the game and the report follows");
    }
    auto played = run_realtime_leg(leg, go_on);
    if (!played) return tl::unexpected(played.error());
    realtime = *played;
    return {};
  };
  if (options.window)
    if (auto played = play_in_real_time(); !played) return tl::unexpected(played.error());

  // --- play in lock-step
  progress.begin(playing);
  const auto scene = scene_from_rig(rig, settings, options.world.ball.restitution_table);
  auto artist = make_artist(scene);
  if (!artist) return tl::unexpected(artist.error());
  PictureParts pictures(rig, scene, std::move(*artist), options.quality);
  const int eyes = options.world.camera.count;
  auto video = VideoFile::create(options.out / "video.mp4", eyes * rig.camera->model.width,
                                 rig.camera->model.height, options.world.camera.rate_hz);
  if (!video) return tl::unexpected(video.error());
  PictureBook book(options.out / "pictures", options.seconds, rig.camera->model, scene);
  book.look_from_outside(
      [&pictures](const FrameRecord& frame) -> const OutsidePicture& { return pictures.outside(frame); });
  Expected<void> shown;
  LockstepPictures parts;
  parts.camera = render;
  parts.refiner = pictures.refiner();
  parts.painter = pictures.painter();
  parts.predictor = pictures.predictor();
  parts.shown = [&](const FrameRecord& frame) {
    video->add(frame.rgb);
    if (shown) shown = book.look(frame);
  };
  LockstepOptions lockstep;
  lockstep.seconds = options.seconds;
  lockstep.seed = options.seed;
  lockstep.graphics = graphics_settings(options.world);
  lockstep.extra_force_delay = seconds(options.world.display.extra_force_delay_s);
  TouchLog touched;
  if (scene.application == "touch")
    lockstep.watch = [&touched](const WorldState& state) { touched.add(state); };
  auto play = play_in_lockstep(world, rig, scene, lockstep, parts, go_on);
  if (!play) return tl::unexpected(play.error());
  if (!shown) return tl::unexpected(shown.error());
  if (auto closed = video->close(); !closed) return tl::unexpected(closed.error());
  if (play->frames.empty())
    return refused("demo: no frame was drawn in {:.0f} s; is the camera's latency longer than that?",
                   options.seconds);

  // --- raw data and summary
  const auto points = check_points(world.truth(), rig);
  const auto overlay = overlay_of_play(*play, rig.camera->model, scene, points);
  if (auto done =
          write_calibration_raw(options.out / "raw", *recordings, rig, world.truth(), poses, *methods);
      !done)
    return tl::unexpected(done.error());
  if (auto done = write_eye_raw(options.out / "raw", EyeSide::left, *play, scene, overlay.frames,
                                rig.camera->model, world.truth().lens);
      !done)
    return tl::unexpected(done.error());
  std::optional<StereoOverlay> stereo;
  if (eyes > 1) {
    const auto& lens = rig.right_camera->model;
    stereo = {overlay_of_right_eye(*play, lens, scene, points), disparity_of_play(*play, rig, points)};
    if (auto done = write_eye_raw(options.out / "raw", EyeSide::right, *play, scene, stereo->right.frames,
                                  lens, world.truth().right_lens);
        !done)
      return tl::unexpected(done.error());
  }
  if (auto done = write_play_raw(options.out / "raw", *play, scene, points); !done)
    return tl::unexpected(done.error());
  if (scene.application == "touch")
    if (auto done = touched.write(options.out / "raw"); !done) return tl::unexpected(done.error());
  Json summary = demo_summary({options, world.truth(), rig, *recordings, *methods, *with_true_tip, *play,
                               overlay, stereo, points.size()});
  if (scene.application == "touch") summary["touch"] = touched.summary();
  summary["pictures"] = book.captions();

  if (!options.window)
    if (auto played = play_in_real_time(); !played) return tl::unexpected(played.error());
  if (realtime) summary["realtime"] = *realtime;

  progress.begin(3);
  if (auto done = write_json(options.out / "summary.json", summary); !done)
    return tl::unexpected(done.error());
  if (auto done = report::write_demo_report(options.out); !done) return tl::unexpected(done.error());
  progress.finish();
  return summary;
}

}  // namespace

Expected<Json> run_demo(const DemoOptions& options) {
  stop_requested();  // from here on Ctrl-C is a request
  try {
    return demo(options);
  } catch (const Interrupted&) {
    return refused(
        "demo: stopped before its end; {} holds what was finished until then, without summary and "
        "report: start it again",
        options.out.string());
  }
}

}  // namespace palpate
