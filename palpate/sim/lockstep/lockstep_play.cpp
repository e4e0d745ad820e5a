#include "palpate/sim/lockstep/lockstep_play.h"

#include <algorithm>
#include <memory>

#include "palpate/device/borrowed_devices.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/server/session/ticked_session.h"
#include "palpate/sim/device_faults.h"
#include "palpate/sim/lockstep/internal/play_recording.h"
#include "palpate/sim/lockstep/internal/watched_devices.h"
#include "palpate/sim/simulated_display.h"

namespace palpate::sim::lockstep {
namespace {

// Haptic records are kept from this long before an impact's start to this long after it.
constexpr double kImpactBefore = 0.010, kImpactAfter = 0.040;

// The camera's pictures are drawn from this long before the first frame that counts.
constexpr double kOpenBefore = 0.1;

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr Duration kLook = std::chrono::milliseconds(5);  // at what is to be recorded

// The simulator's devices go by this name in the play's session.
constexpr const char* kSimulator = "simulator";

// The physics host's clock is the reference: it reads true time.
Instant<PhysicsClock> physics_time(Instant<TrueTime> t) { return {t.since_epoch}; }

// A session on the virtual clock whose devices are the simulator's, and what looks at the truth beside it.
class LockstepPlay {
 public:
  LockstepPlay(Simulator& world, const rig::Rig& rig, const scene::SceneDescription& scene,
               const LockstepOptions& options, const LockstepPictures& pictures)
      : world_(world),
        rig_(rig),
        scene_(scene),
        options_(options),
        pictures_(pictures),
        faults_(world.file()),
        camera_(world, pictures.camera),
        tracker_(world.tracker(), [this](auto& samples) { faults_.disturb(since_, samples); }) {}

  Expected<void> open();
  Expected<LockstepResult> play(const std::function<void(double)>& progress);

 private:
  using Frame = server::graphics::FrameRecord;

  void disturb_cameras();
  device::DriverRegistry devices();
  server::session::SessionSetup setup();
  Expected<void> open_session();
  void open_display();
  Expected<void> begin_counting();
  void tick_physics(Instant<TrueTime> t);
  void show_timecode(Instant<TrueTime> t);
  void take_frame(Instant<TrueTime> t, const Frame& frame);
  bool find_truth(Instant<TrueTime> t, const Frame& frame, evaluation::PlayedFrame& played) const;
  void measure_delay(Instant<TrueTime> t, const Frame& frame);
  void keep_frame(Instant<TrueTime> t, const Frame& frame, evaluation::PlayedFrame played);
  void keep_haptics();
  Expected<LockstepResult> finish();

  server::physics::PhysicsServer& physics() { return session_->physics().server(); }
  server::graphics::GraphicsServer& graphics() { return session_->graphics().server(); }
  double total_s() const { return options_.warm_up_s + options_.seconds; }
  bool counted() const { return since_ > options_.warm_up_s; }

  Simulator& world_;
  const rig::Rig& rig_;
  const scene::SceneDescription& scene_;
  const LockstepOptions& options_;
  const LockstepPictures& pictures_;
  const DeviceFaults faults_;
  WatchedCamera camera_;
  Disturbed<device::TrackerDevice> tracker_;
  std::optional<Disturbed<device::CameraDevice>> right_camera_;
  std::unique_ptr<server::session::TickedSession> session_;
  std::unique_ptr<PlayRecording> recording_;  // null: nothing is recorded
  std::optional<SimulatedDisplay> display_;
  std::optional<evaluation::LatencyMeter> meter_;

  Instant<TrueTime> start_;
  double since_ = 0.0;  // s, the play's own time
  std::optional<haptics::HapticStatistics> before_play_;
  std::uint64_t last_impact_ = 0;
  std::vector<double> impact_times_;
  LockstepResult result_;
};

Expected<void> LockstepPlay::open() {
  if (!rig_.arm || !rig_.camera || !rig_.hand_eye)
    return refused("play: the rig is not calibrated; run `palpate calibrate all`");
  disturb_cameras();
  if (auto opened = open_session(); !opened) return opened;
  if (options_.timecode) open_display();
  if (auto asked = world_.person().ask({device::Gesture::look, "", 0}); !asked)
    return tl::unexpected(asked.error());
  physics().control(scene::Control::pause);  // while warming up the haptic loop hears of a world at rest
  return {};
}

void LockstepPlay::disturb_cameras() {
  camera_.disturb([this](std::optional<device::CameraImage>& image) {
    faults_.disturb(since_, image);
    if (options_.disturb_left_camera) options_.disturb_left_camera(since_, image);
  });
  if (world_.right_camera() == nullptr) return;
  right_camera_.emplace(*world_.right_camera(), [this](std::optional<device::CameraImage>& image) {
    faults_.disturb(since_, image);
    if (options_.disturb_right_camera) options_.disturb_right_camera(since_, image);
  });
}

device::DriverRegistry LockstepPlay::devices() {
  device::DriverRegistry drivers;
  drivers.add(
      device::borrowed_devices(kSimulator, {.arm = &world_.arm(),
                                            .arm_facts = {.simulated = true,
                                                          .identity = kSimulator,
                                                          .states_place = world_.file().states_place(),
                                                          .peak_n = {},
                                                          .continuous_n = {}},
                                            .tracker = &tracker_,
                                            .camera = &camera_,
                                            .right_camera = right_camera_ ? &*right_camera_ : nullptr,
                                            .hand = &world_.hand(),
                                            .simulated = true}));
  return drivers;
}

server::session::SessionSetup LockstepPlay::setup() {
  server::session::SessionSetup setup;
  setup.physics.rig = rig_;
  setup.physics.applications = options_.applications;
  setup.physics.scene = scene_;
  setup.physics.drivers = devices();
  setup.physics.arm.uri = kSimulator;
  setup.physics.run.seed = options_.seed;
  setup.physics.extra_force_delay = options_.extra_force_delay;
  setup.graphics.world = world_.file();
  setup.graphics.stand_in = kSimulator;
  setup.graphics.right_camera_own_clock = options_.right_camera_own_clock;
  setup.graphics.graphics = options_.graphics;
  setup.graphics.pixels = server::session::Pixels::unseen;
  setup.graphics.player = true;
  setup.graphics.seed = options_.seed;
  setup.graphics.player_extra_delay_s = options_.player_extra_delay_s;
  setup.pipeline = pictures_.pipeline;
  return setup;
}

Expected<void> LockstepPlay::open_session() {
  world_.begin_play();
  server::session::VirtualTime time;
  time.begin = world_.now();
  time.graphics = [this](Instant<TrueTime> t) { return world_.graphics_clock().at(t); };
  time.channel = options_.channel;
  time.seed = options_.seed;
  time.drawing_time = options_.drawing_time;
  auto session = server::session::TickedSession::open(setup(), time);
  if (!session) return tl::unexpected(session.error());
  session_ = std::move(*session);
  return {};
}

void LockstepPlay::open_display() {
  display_.emplace(world_.file());
  camera_.see(&*display_);
  meter_.emplace(evaluation::LatencySettings{.exposure = seconds(world_.file().camera.exposure_s),
                                             .scan_out = options_.graphics.scan_out,
                                             .readout = seconds(config::readout_s(world_.file()))});
}

Expected<LockstepResult> LockstepPlay::play(const std::function<void(double)>& progress) {
  start_ = world_.now();
  for (Instant<TrueTime> t = start_ + kTick; to_seconds(t - start_) <= total_s(); t += kTick) {
    since_ = to_seconds(t - start_);
    world_.advance_to(t);
    if (counted() && !before_play_)
      if (auto begun = begin_counting(); !begun) return tl::unexpected(begun.error());
    tick_physics(t);
    if (auto failure = physics().trouble(); !failure.empty())
      return refused("{:.3f} s after its beginning the play ended: {}", since_, failure);
    if (meter_) show_timecode(t);
    camera_.close(since_ < options_.warm_up_s - kOpenBefore);
    const Frame* frame = session_->tick_graphics(t);
    if (options_.conditions) options_.conditions(since_, graphics().conditions());
    if (frame != nullptr) take_frame(t, *frame);
    if (frame != nullptr && progress) progress(since_ / total_s());
    // The loop keeps five seconds; take what belongs to impacts every second.
    if ((t - start_).count() % 1'000'000'000 == 0 || t + kTick > start_ + seconds(total_s())) keep_haptics();
  }
  return finish();
}

// The warm-up is over.
Expected<void> LockstepPlay::begin_counting() {
  before_play_ = physics().haptic().statistics();
  if (!options_.record.empty()) {
    auto begun = PlayRecording::begin(options_.record, session_->physics(), rig_);
    if (!begun) return tl::unexpected(begun.error());
    recording_ = std::move(*begun);
  }
  physics().control(scene::Control::resume);
  return {};
}

void LockstepPlay::tick_physics(Instant<TrueTime> t) {
  session_->tick_physics(t);
  if (recording_ && (t - start_).count() % kLook.count() == 0) recording_->look();
  if (counted() && options_.watch) options_.watch(physics().newest());
  if (physics().impact().number == last_impact_) return;
  last_impact_ = physics().impact().number;
  if (!options_.pass_on) impact_times_.push_back(physics().impact().start.seconds());
}

void LockstepPlay::show_timecode(Instant<TrueTime> t) {
  const auto now = world_.graphics_clock().at(t);
  const Duration code = now.since_epoch % device::kTimecodeCycle;
  display_->show(t, code);
  meter_->timecode_shown(now, code);
}

void LockstepPlay::take_frame(Instant<TrueTime> t, const Frame& frame) {
  evaluation::PlayedFrame played;
  const bool known = find_truth(t, frame, played);
  const auto predictions = graphics().take_prediction_errors();
  if (!counted()) return;
  if (!options_.pass_on)
    result_.predictions.insert(result_.predictions.end(), predictions.begin(), predictions.end());
  if (meter_) measure_delay(t, frame);
  if (!frame.have_state || !known) return;
  if (pictures_.shown) pictures_.shown(frame);
  keep_frame(t, frame, std::move(played));
}

// What was true when the frame's image was taken, or, of a predicted one, is true when its light leaves the display.
bool LockstepPlay::find_truth(Instant<TrueTime> t, const Frame& frame,
                              evaluation::PlayedFrame& played) const {
  const bool known = camera_.truth_of(frame.camera_frame, played);
  if (frame.picture_time == server::graphics::PictureTime::predicted) {
    // Its light leaves the display now, where scanning out takes no time.
    played.truth.X_world_camera = world_.true_camera_at(t + options_.graphics.scan_out);
    played.true_tip = world_.true_state().X_world_tip.translation;
  }
  if (frame.right)
    played.right_truth = evaluation::CameraView{
        world_.truth().right_lens, played.truth.X_world_camera * world_.truth().X_marker_camera.inverse() *
                                       world_.truth().X_marker_right_camera};
  return known;
}

void LockstepPlay::measure_delay(Instant<TrueTime> t, const Frame& frame) {
  const auto taken = world_.camera_clock().true_time(frame.stamp);
  if (const auto delay = meter_->look(graphics().finished_image(), frame, world_.graphics_clock().at(t)))
    result_.delays.push_back({*delay, t + seconds(world_.file().display.scan_out_s) - taken});
  else
    ++result_.timecodes_unread;
}

void LockstepPlay::keep_frame(Instant<TrueTime> t, const Frame& frame, evaluation::PlayedFrame played) {
  played.record = frame;
  played.shown_tip = scene::shown_tip(frame.state, scene_);
  played.record.rgb = {};  // an emptied one would keep its megabyte
  const auto now = world_.graphics_clock().at(t);
  const auto& model = graphics().sync().model();
  const double sync_error_s = to_seconds(model.to(now) - physics_time(t));
  if (options_.pass_on) {
    options_.pass_on({.played = played,
                      .sync_error_s = sync_error_s,
                      .sync_uncertainty_s = to_seconds(model.uncertainty(now)),
                      .round_trips_s = graphics().take_round_trips()});
  } else {
    result_.frames.push_back(std::move(played));
    result_.sync_errors_s.push_back(sync_error_s);
  }
}

// What belongs to impacts, and to forces that last.
void LockstepPlay::keep_haptics() {
  if (options_.pass_on) return;
  const double from = result_.haptics.empty() ? 0.0 : result_.haptics.back().time.seconds();
  for (const auto& r : physics().haptic().records()) {
    const double at = r.time.seconds();
    if (at <= from) continue;
    // A lasting force is no impact: kept while it is asked for.
    const bool lasting = impact_times_.empty() && counted() && r.requested != Vector3::Zero();
    const bool near_impact = std::any_of(impact_times_.begin(), impact_times_.end(), [at](double impact) {
      return at >= impact - kImpactBefore && at <= impact + kImpactAfter;
    });
    if (near_impact || lasting) result_.haptics.push_back(r);
  }
}

Expected<LockstepResult> LockstepPlay::finish() {
  if (recording_)
    if (auto ended = recording_->end(); !ended) return tl::unexpected(ended.error());
  const haptics::HapticStatistics before = before_play_.value_or(haptics::HapticStatistics{});
  result_.haptic = physics().haptic().statistics();
  result_.haptic.ticks -= before.ticks;
  result_.haptic.limited_ticks -= before.limited_ticks;
  result_.haptic.peak_limited_ticks -= before.peak_limited_ticks;
  result_.haptic.fault_ticks -= before.fault_ticks;
  result_.haptic.bad_samples -= before.bad_samples;
  result_.exchange = session_->graphics().link().counters();
  result_.final_state = physics().newest();
  result_.round_trips_s = graphics().take_round_trips();
  return std::move(result_);
}

}  // namespace

server::graphics::GraphicsSettings graphics_settings(const config::WorldFile& world) {
  return {.picture_time = world.display.picture_time == "predicted"
                              ? server::graphics::PictureTime::predicted
                              : server::graphics::PictureTime::registered,
          .scan_out = seconds(world.display.scan_out_s),
          .extra_delay = seconds(world.display.extra_picture_delay_s)};
}

Expected<LockstepResult> play_in_lockstep(Simulator& world, const rig::Rig& rig,
                                          const scene::SceneDescription& scene,
                                          const LockstepOptions& options, const LockstepPictures& pictures,
                                          const std::function<void(double)>& progress) {
  LockstepPlay play(world, rig, scene, options, pictures);
  if (auto opened = play.open(); !opened) return tl::unexpected(opened.error());
  return play.play(progress);
}

}  // namespace palpate::sim::lockstep
