#include "tools/demo/demo.h"

#include <algorithm>

#include "applications/scene_settings.h"
#include "applications/touched_mesh.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/core/progress.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/render/picture_file.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/camera_renderer.h"
#include "tools/demo/demo_raw.h"
#include "tools/demo/demo_report.h"
#include "tools/demo/demo_summary.h"
#include "tools/demo/realtime_run.h"
#include "tools/demo/snapshot_selector.h"
#include "tools/demo/touch_log.h"

namespace palpate::tools::demo {
namespace {

// Thrown where the demo looks at Ctrl-C: on its way out the processes it started end and unfinished files go.
struct Interrupted {};

void go_on_unless_stopped() {
  if (stop_requested().load()) throw Interrupted{};
}

// Somebody at a desk does not turn the head twenty degrees and back every second; they move it a little,
// which is how depth is seen. And they begin with slow serves.
sim::config::WorldFile for_a_person(sim::config::WorldFile world) {
  world.head.turn_peak = std::min(world.head.turn_peak, radians_from_degrees(4.0));
  world.head.turn_hz = std::min(world.head.turn_hz, 0.15);
  world.head.shake = std::min(world.head.shake, radians_from_degrees(0.05));
  world.ball.serve_speed[1] = std::min(world.ball.serve_speed[1], std::max(2.3, world.ball.serve_speed[0]));
  return world;
}

calibration::session::CalibrationPlan plan_for(const DemoOptions& options) {
  calibration::session::CalibrationPlan plan;
  if (options.quick) {
    plan.board_s = 6.0;
    plan.board_every = 3;
    plan.lens_views = 20;
    plan.look_s = 2.0;
  }
  plan.reach = evaluation::reach_of(options.world);
  plan.guidance_seed = options.seed;
  // A simulated laboratory has no calendar: the same run gives the same file, on whatever day.
  plan.date = "1970-01-01T00:00:00Z";
  return plan;
}

Expected<Json> demo(const DemoOptions& options) {
  // Known now, not after minutes of calibration.
  auto settings = applications::scene_settings(options.world, options.application);
  if (auto mesh = applications::read_touched_mesh(settings); !mesh) return tl::unexpected(mesh.error());
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
  sim::Simulator world(options.world, options.seed);
  world.set_renderer(render);

  rig::Rig rig = evaluation::blank_rig(options.world);
  const auto rig_path = options.out / "rig.toml";
  const calibration::session::CalibrationPlan plan = plan_for(options);
  calibration::session::SessionHooks hooks;
  hooks.progress = [&progress](std::size_t step, std::size_t steps, const std::string&) {
    go_on_unless_stopped();
    progress.update(static_cast<double>(step) / static_cast<double>(steps));
  };
  hooks.save = [&rig_path](const rig::Rig& so_far) { return rig::write_rig(rig_path, so_far); };
  hooks.find_landmarks = calibration::session::landmark_finder();
  auto recordings = calibration::session::calibrate_rig(evaluation::laboratory_of(world), rig, plan, hooks);
  if (!recordings) return tl::unexpected(recordings.error());

  const auto poses = evaluation::judging_poses(options.world, options.seed);
  auto methods =
      evaluation::compare_arm_methods(recordings->arm_train, recordings->arm_test, rig.nominal_lengths,
                                      rig.tip_pivot->tip_in_marker, world.truth(), poses);
  if (!methods) return tl::unexpected(methods.error());
  auto with_true_tip =
      evaluation::compare_arm_methods(recordings->arm_train, recordings->arm_test, rig.nominal_lengths,
                                      world.truth().tip_in_marker, world.truth(), poses);
  if (!with_true_tip) return tl::unexpected(with_true_tip.error());

  const auto world_path = options.out / "world.toml";
  if (auto done = write_file(world_path, sim::config::world_text(options.world)); !done)
    return tl::unexpected(done.error());

  // --- in real time, as three processes
  std::optional<Json> realtime;
  const auto play_in_real_time = [&]() -> Expected<void> {
    if (options.program.empty() || options.realtime_s <= 0.0) return {};
    progress.begin(in_real_time);
    RealtimeRunOptions run;
    run.program = options.program;
    run.rig = rig_path;
    run.application = options.application;
    run.quality = options.quality;
    run.world = world_path;
    run.out = options.out / "raw";
    run.seed = options.seed;
    run.seconds = options.realtime_s;
    run.two_hosts = options.two_hosts;
    run.scan_out = seconds(options.world.display.scan_out_s);
    run.graphics_clock = options.world.clocks.graphics_host;
    run.window = options.window;
    run.monitor = options.monitor;
    if (options.window) {
      run.world = options.out / "world-window.toml";
      if (auto done = write_file(run.world, sim::config::world_text(for_a_person(options.world))); !done)
        return done;
      if (options.notice)
        options.notice(
            "demo: the window opens; move the mouse in it to play, q ends the game and the report follows");
    }
    auto played = run_realtime(run, go_on);
    if (!played) return tl::unexpected(played.error());
    realtime = *played;
    return {};
  };
  if (options.window)
    if (auto played = play_in_real_time(); !played) return tl::unexpected(played.error());

  // --- play in lock-step
  progress.begin(playing);
  const auto scene = server::physics::scene_from_rig(rig, settings, options.world.ball.restitution_table);
  auto scene_view = options.applications.make_view(scene);
  if (!scene_view) return tl::unexpected(scene_view.error());
  server::graphics::FrameRenderer pictures(rig, scene, std::move(*scene_view), options.quality);
  const int eyes = options.world.camera.count;
  auto video = render::VideoFile::create(options.out / "video.mp4", eyes * rig.camera->model.width,
                                         rig.camera->model.height, options.world.camera.rate_hz);
  if (!video) return tl::unexpected(video.error());
  SnapshotSelector book(options.out / "pictures", options.seconds, rig.camera->model, scene);
  book.look_from_outside(
      [&pictures](const server::graphics::FrameRecord& frame) -> const render::OutsidePicture& {
        return pictures.outside(frame);
      });
  Expected<void> shown;
  sim::lockstep::LockstepPictures parts;
  parts.camera = render;
  parts.pipeline = &pictures;
  parts.shown = [&](const server::graphics::FrameRecord& frame) {
    video->add(frame.rgb);
    if (shown) shown = book.look(frame);
  };
  sim::lockstep::LockstepOptions lockstep;
  lockstep.applications = options.applications;
  lockstep.seconds = options.seconds;
  lockstep.seed = options.seed;
  lockstep.graphics = sim::lockstep::graphics_settings(options.world);
  lockstep.extra_force_delay = seconds(options.world.display.extra_force_delay_s);
  TouchLog touched;
  if (scene.application == "touch")
    lockstep.watch = [&touched](const scene::SceneState& state) { touched.add(state); };
  auto play = sim::lockstep::play_in_lockstep(world, rig, scene, lockstep, parts, go_on);
  if (!play) return tl::unexpected(play.error());
  if (!shown) return tl::unexpected(shown.error());
  if (auto closed = video->close(); !closed) return tl::unexpected(closed.error());
  if (play->frames.empty())
    return refused("demo: no frame was drawn in {:.0f} s; is the camera's latency longer than that?",
                   options.seconds);

  // --- raw data and summary
  const auto points = evaluation::check_points(world.truth(), rig);
  const auto overlay = evaluation::overlay_of_play(play->frames, rig.camera->model, scene, points);
  if (auto done =
          write_calibration_raw(options.out / "raw", *recordings, rig, world.truth(), poses, *methods);
      !done)
    return tl::unexpected(done.error());
  if (auto done = write_eye_raw(options.out / "raw", server::graphics::EyeSide::left, *play, scene,
                                overlay.frames, rig.camera->model, world.truth().lens);
      !done)
    return tl::unexpected(done.error());
  std::optional<StereoOverlay> stereo;
  if (eyes > 1) {
    const auto& lens = rig.right_camera->model;
    stereo = {evaluation::overlay_of_right_eye(play->frames, lens, scene, points),
              evaluation::disparity_of_play(play->frames, rig, points)};
    if (auto done = write_eye_raw(options.out / "raw", server::graphics::EyeSide::right, *play, scene,
                                  stereo->right.frames, lens, world.truth().right_lens);
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
  if (auto done = write_demo_report(options.out); !done) return tl::unexpected(done.error());
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

}  // namespace palpate::tools::demo
