#include "tools/demo/demo.h"

#include <algorithm>
#include <array>

#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/core/progress.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/render/picture_file.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/config/world_scene.h"
#include "tools/demo/demo_raw.h"
#include "tools/demo/demo_report.h"
#include "tools/demo/demo_summary.h"
#include "tools/demo/provenance.h"
#include "tools/demo/raw_files.h"
#include "tools/demo/realtime_run.h"
#include "tools/demo/snapshot_selector.h"

namespace palpate::tools::demo {
namespace {

// Thrown where the demo looks at Ctrl-C: on its way out the processes it started end and unfinished files go.
struct Interrupted {};

double picture_rate(const DemoOptions& options) {
  return std::min(options.world.camera.rate_hz, options.most_pictures / options.seconds);
}

void go_on_unless_stopped() {
  if (stop_requested().load()) throw Interrupted{};
}

// Somebody at a desk does not turn the head twenty degrees and back every second; they move it a little,
// which is how depth is seen. And the application goes easy on them.
sim::config::WorldFile for_a_person(sim::config::WorldFile world, const scene::ApplicationSpec& application) {
  world.head.turn_peak = std::min(world.head.turn_peak, radians_from_degrees(4.0));
  world.head.turn_hz = std::min(world.head.turn_hz, 0.15);
  world.head.shake = std::min(world.head.shake, radians_from_degrees(0.05));
  if (application.ease_for_a_person) application.ease_for_a_person(world.settings);
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
  plan.lens = device::lens_kind(options.world.camera.lens).value_or(plan.lens);
  // A simulated laboratory has no calendar: the same run gives the same file, on whatever day.
  plan.now = [] { return rig::kSimulatedDate; };
  return plan;
}

// Another's files stay as they are: a demo replaces its rig.toml, and the pictures in its folder.
Expected<void> check_folder(const std::filesystem::path& folder) {
  std::error_code none;
  const auto is_folder = [&](const char* name) { return std::filesystem::is_directory(folder / name, none); };
  if (!std::filesystem::is_directory(folder, none) || (is_folder("raw") && is_folder("pictures"))) return {};
  const std::filesystem::directory_iterator first(folder, none);
  if (none || first == std::filesystem::directory_iterator()) return {};
  return wrong_use("--out {}: holds '{}' and is no folder of a demo; a new folder is expected",
                   folder.string(), excerpt(first->path().filename().string(), 60));
}

// A rig that has been calibrated further since its demo ended is not replaced: it gets a name beside.
Expected<void> keep_changed_rig(const std::filesystem::path& folder) {
  const auto rig = folder / "rig.toml";
  std::error_code failed;
  const auto changed = std::filesystem::last_write_time(rig, failed);
  if (failed) return {};
  const auto ended = std::filesystem::last_write_time(folder / "summary.json", failed);
  if (failed || changed <= ended) return {};
  for (int number = 1; number < 1000; ++number) {
    const auto kept = folder / fmt::format("rig-before-{}.toml", number);
    if (is_there(kept)) continue;
    std::filesystem::rename(rig, kept, failed);
    if (failed)
      return refused(
          "{}: has been changed since its demo and cannot be renamed ({}); --out names another folder",
          rig.string(), failed.message());
    fmt::print(stderr, "demo: {} has been changed since its demo; it is {} now\n", rig.string(),
               kept.filename().string());
    return {};
  }
  return refused("{}: has been changed since its demo; --out names another folder", rig.string());
}

// What an earlier demo left must not be taken for this one's.
Expected<void> prepare_folder(const DemoOptions& options) {
  if (auto fine = check_folder(options.out); !fine) return fine;
  for (const auto& folder : {options.out, options.out / "raw", options.out / "pictures"})
    if (auto made = make_folder(folder); !made) return made;
  std::error_code ignored;
  if (std::filesystem::exists(options.out / "summary.json", ignored))
    fmt::print(stderr, "demo: report and rig.toml in {} are replaced; --out names another folder\n",
               options.out.string());
  if (auto kept = keep_changed_rig(options.out); !kept) return kept;
  for (const auto* old : {"summary.json", "report.json", "report.html", "video.mp4"})
    std::filesystem::remove(options.out / old, ignored);
  for (const auto& old : raw_files()) std::filesystem::remove(options.out / "raw" / old.file, ignored);
  for (const auto& application : options.applications.specs())
    for (const auto& table : application.tables)
      std::filesystem::remove(options.out / "raw" / table.file, ignored);
  for (const auto& old : std::filesystem::directory_iterator(options.out / "pictures", ignored))
    if (old.path().extension() == ".png") std::filesystem::remove(old.path(), ignored);
  return {};
}

// Known now, not after minutes of calibration.
Expected<scene::SceneDescription> check(const DemoOptions& options) {
  if (options.world.states_place())
    return wrong_use(
        "--world: the laboratory's arm states its place, and a demo calibrates a PHANToM; a world without "
        "[arm] model is expected (palpate lockstep --world FILE --rig FILE plays with the other)");
  auto scene = sim::config::scene_of(options.world, options.applications, options.application);
  if (!scene) return scene;
  if (auto mesh = scene::read_mesh_asset(*scene); !mesh) return tl::unexpected(mesh.error());
  if (auto fine = JointRecording(options.record).check(); !fine) return tl::unexpected(fine.error());
  if (options.two_hosts)
    if (auto possible = TwoHosts::make(); !possible) return tl::unexpected(possible.error());
  return scene;
}

// The parts of a demo, called in order; each works on what those before have found.
class Demo {
 public:
  Demo(const DemoOptions& options, scene::SceneDescription settings,
       const scene::ApplicationSpec& application);

  Expected<void> calibrate();
  Expected<void> play_in_real_time();
  Expected<void> play_in_lockstep();
  Expected<void> write_raw();
  Expected<DemoResult> write_report();

 private:
  enum Phase : std::size_t { kCalibrating, kFirstPlay, kSecondPlay, kWriting };

  std::vector<Progress::Phase> phases() const;
  void begin(Phase phase, const std::string& what);
  void go_on(double share) {
    go_on_unless_stopped();
    progress_.update(share);
  }
  Expected<void> compare_methods();
  sim::RenderView camera_renderer();

  const DemoOptions& options_;
  const scene::ApplicationSpec& application_;
  scene::SceneDescription scene_;  // without surfaces until the rig is calibrated
  std::filesystem::path raw_, rig_path_, world_path_;
  Provenance provenance_;
  Progress progress_;
  sim::CameraRenderer renderer_;  // outlives the world, which holds on to it
  sim::Simulator world_;
  rig::Rig rig_;
  std::optional<calibration::session::CalibrationRecordings> recordings_;
  std::vector<Vector3> poses_;  // at which the methods are judged
  std::vector<evaluation::MethodErrors> methods_, with_true_tip_;
  std::optional<Json> realtime_;
  std::unique_ptr<scene::PlayRecord> record_;
  sim::lockstep::LockstepResult play_;
  Json captions_;
  std::vector<evaluation::CheckPoint> points_;
  evaluation::OverlayOfPlay overlay_;
  std::optional<StereoOverlay> stereo_;
};

Demo::Demo(const DemoOptions& options, scene::SceneDescription settings,
           const scene::ApplicationSpec& application)
    : options_(options),
      application_(application),
      scene_(std::move(settings)),
      raw_(options.out / "raw"),
      rig_path_(options.out / "rig.toml"),
      world_path_(options.out / "world.toml"),
      provenance_(options.build),
      progress_(phases()),
      world_(options.world, options.seed),
      rig_(evaluation::blank_rig(options.world)) {
  world_.set_renderer(camera_renderer());
}

std::vector<Progress::Phase> Demo::phases() const {
  std::vector<Progress::Phase> phases = {{"calibrating", options_.quick ? 8.0 : 20.0},
                                         {"playing", 1.5 * options_.seconds},
                                         {"playing in real time", options_.realtime_s + 2.0},
                                         {"writing the report", 2.0}};
  if (options_.window)
    std::swap(phases[kFirstPlay], phases[kSecondPlay]);  // a person at the window comes first
  return phases;
}

// A log or a pipe, which no bar is drawn into, has a line of each phase.
void Demo::begin(Phase phase, const std::string& what) {
  progress_.begin(phase);
  if (!progress_.on_terminal()) Log("demo").write(LogLevel::info, what);
}

sim::RenderView Demo::camera_renderer() {
  return [this](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
    go_on_unless_stopped();
    renderer_.render(view, rgb);
  };
}

Expected<void> Demo::calibrate() {
  begin(kCalibrating, "calibrates everything");
  calibration::session::SessionHooks hooks;
  hooks.progress = [this](std::size_t step, std::size_t steps, const std::string&) {
    go_on(static_cast<double>(step) / static_cast<double>(steps));
  };
  hooks.save = [this](const rig::Rig& so_far) { return rig::write_rig(rig_path_, so_far); };
  hooks.find_landmarks = calibration::session::landmark_finder();
  auto recordings =
      calibration::session::calibrate_rig(evaluation::laboratory_of(world_), rig_, plan_for(options_), hooks);
  if (!recordings) return tl::unexpected(recordings.error());
  recordings_ = std::move(*recordings);
  if (auto compared = compare_methods(); !compared) return compared;
  scene_ = server::physics::scene_from_rig(rig_, scene_);
  auto record = options_.applications.make_record(scene_);
  if (!record) return tl::unexpected(record.error());
  record_ = std::move(*record);
  return write_file(world_path_, sim::config::world_text(options_.world));
}

Expected<void> Demo::compare_methods() {
  poses_ = evaluation::judging_poses(options_.world, options_.seed);
  const auto& truth = world_.truth();
  auto methods =
      evaluation::compare_arm_methods(recordings_->arm_train, recordings_->arm_test, rig_.nominal_arm.lengths,
                                      rig_.tip_pivot->tip_in_marker, truth, poses_);
  if (!methods) return tl::unexpected(methods.error());
  methods_ = std::move(*methods);
  auto with_true_tip =
      evaluation::compare_arm_methods(recordings_->arm_train, recordings_->arm_test, rig_.nominal_arm.lengths,
                                      truth.tip_in_marker, truth, poses_);
  if (!with_true_tip) return tl::unexpected(with_true_tip.error());
  with_true_tip_ = std::move(*with_true_tip);
  return {};
}

// As three processes.
Expected<void> Demo::play_in_real_time() {
  if (options_.program.empty() || options_.realtime_s <= 0.0) return {};
  begin(options_.window ? kFirstPlay : kSecondPlay,
        fmt::format("plays {:g} s in real time", options_.realtime_s));
  RealtimeRunOptions run;
  run.program = options_.program;
  run.rig = rig_path_;
  run.application = options_.application;
  run.applications = options_.applications;
  run.quality = options_.quality;
  run.world = world_path_;
  run.out = raw_;
  run.seed = options_.seed;
  run.seconds = options_.realtime_s;
  run.two_hosts = options_.two_hosts;
  run.scan_out = seconds(options_.world.display.scan_out_s);
  run.graphics_clock = options_.world.clocks.graphics_host;
  run.window = options_.window;
  run.monitor = options_.monitor;
  run.headset = options_.headset;
  run.recording = JointRecording(options_.record);
  run.recorded_pictures = options_.recorded_pictures;
  if (options_.window) {
    run.world = options_.out / "world-window.toml";
    if (auto done =
            write_file(run.world, sim::config::world_text(for_a_person(options_.world, application_)));
        !done)
      return done;
    Log("demo").info(
        "the window opens; move the mouse in it to play, q ends the game and the report follows");
  }
  auto played = run_realtime(run, [this](double share) { go_on(share); });
  if (!played) return tl::unexpected(played.error());
  realtime_ = std::move(*played);
  return {};
}

Expected<void> Demo::play_in_lockstep() {
  begin(options_.window ? kSecondPlay : kFirstPlay,
        fmt::format("plays {:g} s in lock-step", options_.seconds));
  auto scene_view = options_.applications.make_view(scene_);
  if (!scene_view) return tl::unexpected(scene_view.error());
  server::graphics::FrameRenderer pictures(rig_, scene_, std::move(*scene_view),
                                           options_.quality.value_or(render::Quality::medium));
  const auto& lens = rig_.camera->model;
  auto video = render::VideoFile::create(options_.out / "video.mp4", options_.world.camera.count * lens.width,
                                         lens.height, picture_rate(options_));
  if (!video) return tl::unexpected(video.error());
  SnapshotSelector book(options_.out / "pictures", options_.seconds, lens, *record_);
  book.look_from_outside(
      [&pictures](const server::graphics::FrameRecord& frame) -> const render::OutsidePicture& {
        return pictures.outside(frame);
      });
  Expected<void> shown;
  sim::lockstep::LockstepPictures parts;
  parts.camera = camera_renderer();
  parts.pipeline = &pictures;
  parts.shown = [&](const server::graphics::FrameRecord& frame) {
    video->add(frame.rgb);
    record_->add_picture(frame.state);
    if (shown) shown = book.look(frame);
  };
  sim::lockstep::LockstepOptions lockstep;
  lockstep.applications = options_.applications;
  lockstep.seconds = options_.seconds;
  lockstep.seed = options_.seed;
  lockstep.graphics = sim::lockstep::graphics_settings(options_.world);
  lockstep.extra_force_delay = seconds(options_.world.display.extra_force_delay_s);
  world_.set_camera_rate(picture_rate(options_));
  lockstep.watch = [this](const scene::SceneState& state) { record_->add_state(state); };
  auto play = sim::lockstep::play_in_lockstep(world_, rig_, scene_, lockstep, parts,
                                              [this](double share) { go_on(share); });
  if (!play) return tl::unexpected(play.error());
  if (!shown) return shown;
  if (auto closed = video->close(); !closed) return closed;
  if (play->frames.empty())
    return refused("demo: no frame was drawn in {:.0f} s; is the camera's latency longer than that?",
                   options_.seconds);
  play_ = std::move(*play);
  captions_ = book.captions();
  return {};
}

Expected<void> Demo::write_raw() {
  const auto& truth = world_.truth();
  points_ = evaluation::check_points(truth, rig_);
  if (auto done = write_calibration_raw(raw_, *recordings_, rig_, truth, poses_, methods_); !done)
    return done;
  overlay_ = evaluation::overlay_of_play(play_.frames, rig_.camera->model, points_);
  if (auto done = write_eye_raw(raw_, server::graphics::EyeSide::left, play_, overlay_.frames,
                                rig_.camera->model, truth.lens);
      !done)
    return done;
  if (options_.world.camera.count > 1) {
    const auto& lens = rig_.right_camera->model;
    stereo_ = {evaluation::overlay_of_right_eye(play_.frames, lens, points_),
               evaluation::disparity_of_play(play_.frames, rig_, points_)};
    if (auto done = write_eye_raw(raw_, server::graphics::EyeSide::right, play_, stereo_->right.frames, lens,
                                  truth.right_lens);
        !done)
      return done;
  }
  if (auto done = write_play_raw(raw_, play_, points_); !done) return done;
  return write_tables(raw_, application_, *record_);
}

Expected<DemoResult> Demo::write_report() {
  begin(kWriting, "writes the report");
  auto summary = demo_summary({options_, world_.truth(), rig_, *recordings_, methods_, with_true_tip_, play_,
                               overlay_, stereo_, points_.size(), scene_, *record_});
  if (!summary) return tl::unexpected(summary.error());
  (*summary)["pictures"] = captions_;
  if (realtime_) (*summary)["realtime"] = *realtime_;
  for (const auto& line : own_game(*summary, *record_))
    (*summary)["realtime"]["own_game"].push_back(line.text);
  (*summary)["made"] = provenance_.told(realtime_.value_or(Json()));
  if (auto done = write_json(options_.out / "summary.json", *summary); !done)
    return tl::unexpected(done.error());
  const auto report = write_demo_report(options_.out, options_.applications);
  if (!report) return tl::unexpected(report.error());
  progress_.finish();
  return DemoResult{*summary, closing_lines(*summary, record_->closing_lines(*summary), (*report)["verdicts"],
                                            options_.out)};
}

Expected<DemoResult> demo(const DemoOptions& options) {
  const auto* application = options.applications.find(options.application);
  if (application == nullptr)
    return wrong_use("--app {}: not known; `palpate apps` lists the applications there are",
                     options.application);
  auto settings = check(options);
  if (!settings) return tl::unexpected(settings.error());
  if (auto made = prepare_folder(options); !made) return tl::unexpected(made.error());
  Demo demo(options, std::move(*settings), *application);
  if (auto done = demo.calibrate(); !done) return tl::unexpected(done.error());
  // A person at the window comes first.
  if (options.window)
    if (auto done = demo.play_in_real_time(); !done) return tl::unexpected(done.error());
  if (auto done = demo.play_in_lockstep(); !done) return tl::unexpected(done.error());
  if (auto done = demo.write_raw(); !done) return tl::unexpected(done.error());
  if (!options.window)
    if (auto done = demo.play_in_real_time(); !done) return tl::unexpected(done.error());
  return demo.write_report();
}

}  // namespace

Expected<DemoResult> run_demo(const DemoOptions& options) {
  stop_requested();  // from here on Ctrl-C is a request
  try {
    auto done = demo(options);
    // An application that was stopped while it prepares itself refuses.
    if (!done) go_on_unless_stopped();
    return done;
  } catch (const Interrupted&) {
    return refused(
        "demo: stopped before its end; {} holds what was finished until then, without summary and "
        "report: start it again",
        options.out.string());
  }
}

}  // namespace palpate::tools::demo
