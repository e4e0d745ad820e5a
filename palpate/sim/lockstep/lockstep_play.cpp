#include "palpate/sim/lockstep/lockstep_play.h"

#include <algorithm>
#include <deque>

#include "palpate/desktop/scripted_user.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/device_faults.h"
#include "palpate/sim/simulated_display.h"

namespace palpate::sim::lockstep {
namespace {

// Haptic records are kept from this long before an impact's start to this long after it.
constexpr double kImpactBefore = 0.010, kImpactAfter = 0.040;

// The camera's pictures are drawn from this long before the first frame that counts.
constexpr double kOpenBefore = 0.1;

// The world's camera, which keeps what it saw of the truth beside each image, and passes the view on to
// whoever draws it.
class WatchedCamera : public device::CameraDevice {
 public:
  WatchedCamera(Simulator& world, RenderView render) : world_(world), render_(std::move(render)) {
    world_.set_renderer([this](const TrueView& view, std::vector<std::uint8_t>& rgb) {
      views_.push_back(view);
      if (closed_)
        rgb.assign(3 * static_cast<std::size_t>(view.lens.width) * static_cast<std::size_t>(view.lens.height),
                   0);
      else if (render_)
        render_(view, rgb);
    });
  }
  ~WatchedCamera() override { world_.set_renderer(render_); }
  // While closed its images are black: nothing is drawn that nobody looks at.
  void close(bool closed) { closed_ = closed; }
  void disturb(std::function<void(std::optional<device::CameraImage>&)> how) { disturb_ = std::move(how); }
  // What hangs in its view; an image that nobody draws is grey otherwise.
  void see(SimulatedDisplay* display) { display_ = display; }

  std::optional<device::CameraImage> poll() override {
    views_.clear();
    auto image = world_.camera().poll();
    if (image && !views_.empty()) {
      // A picture is made of one view or of several; the middle one is mid-exposure.
      const auto& view = views_[views_.size() / 2];
      seen_.push_back({image->frame, {view.lens, view.X_world_camera}, true_tip(view)});
      if (seen_.size() > kKept) seen_.pop_front();
      if (display_ != nullptr && !closed_) {
        if (image->rgb.empty())
          image->rgb.assign(
              3 * static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height), kGrey);
        display_->paint(*image, view, world_.camera_clock().true_time(image->mid_exposure));
      }
    }
    if (disturb_) disturb_(image);
    return image;
  }

  // What was true when the image of this number was taken; it may have been held back since.
  bool truth_of(std::uint64_t frame, evaluation::PlayedFrame& played) const {
    for (const auto& seen : seen_) {
      if (seen.frame != frame) continue;
      played.truth = seen.truth;
      played.true_tip = seen.true_tip;
      return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kKept = 64;
  static constexpr std::uint8_t kGrey = 110;
  struct Seen {
    std::uint64_t frame = 0;
    evaluation::CameraView truth;
    Vector3 true_tip = Vector3::Zero();
  };
  Simulator& world_;
  RenderView render_;
  std::vector<TrueView> views_;
  std::deque<Seen> seen_;
  std::function<void(std::optional<device::CameraImage>&)> disturb_;
  SimulatedDisplay* display_ = nullptr;
  bool closed_ = false;
};

template <typename Device>
class Disturbed : public Device {
 public:
  using Polled = decltype(std::declval<Device&>().poll());
  Disturbed(Device& device, std::function<void(Polled&)> how) : device_(device), how_(std::move(how)) {}
  Polled poll() override {
    Polled polled = device_.poll();
    if (how_) how_(polled);
    return polled;
  }

 private:
  Device& device_;
  std::function<void(Polled&)> how_;
};

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
  if (!rig.arm || !rig.camera || !rig.hand_eye)
    return refused("play: the rig is not calibrated; run `palpate calibrate all`");
  auto application = options.applications.make_physics(scene, {.seed = options.seed});
  if (!application) return tl::unexpected(application.error());

  // The physics host's clock is the reference: it reads true time.
  const auto physics_time = [](Instant<TrueTime> t) { return Instant<PhysicsClock>{t.since_epoch}; };
  const auto graphics_time = [&world](Instant<TrueTime> t) { return world.graphics_clock().at(t); };

  haptics::HapticSettings haptic_settings;
  haptic_settings.limits = haptics::force_limits_of(rig.arm->model);
  haptic_settings.permit = haptics::ForcePermit::of_simulated_arm();
  server::physics::PhysicsServer physics(rig, scene, std::move(*application), world.arm(), haptic_settings);
  physics.delay_forces(options.extra_force_delay);
  world.begin_play();
  transport::InProcessNetwork network(options.channel, options.seed, physics_time, graphics_time);
  network.advance_to(world.now());
  scene::SceneDescription served = scene;
  served.shape_vertices = physics.shape_vertices();
  auto service = network.serve(
      [&physics](Instant<PhysicsClock> t) { return physics.state_at(t); }, std::move(served),
      [&physics](Instant<PhysicsClock> t, std::span<float> out) { return physics.shape_at(t, out); });
  if (!service) return tl::unexpected(service.error());
  auto link = network.connect();
  WatchedCamera camera(world, pictures.camera);
  double since = 0.0;  // s, the play's own time
  const DeviceFaults faults(world.file());
  Disturbed<device::TrackerDevice> tracker(
      world.tracker(), [&](std::vector<device::TrackerSample>& samples) { faults.disturb(since, samples); });
  camera.disturb([&](std::optional<device::CameraImage>& image) {
    faults.disturb(since, image);
    if (options.disturb_left_camera) options.disturb_left_camera(since, image);
  });
  server::graphics::NullFramePipeline blind;
  server::graphics::GraphicsServer graphics(rig, *link, tracker, camera,
                                            pictures.pipeline != nullptr ? *pictures.pipeline : blind,
                                            options.graphics);
  std::optional<Disturbed<device::CameraDevice>> right_camera;
  if (world.right_camera() != nullptr && rig::has_two_eyes(rig)) {
    right_camera.emplace(*world.right_camera(), [&](std::optional<device::CameraImage>& image) {
      faults.disturb(since, image);
      if (options.disturb_right_camera) options.disturb_right_camera(since, image);
    });
    graphics.add_right_camera(*right_camera, !options.right_camera_own_clock);
  }
  std::optional<SimulatedDisplay> display;
  std::optional<evaluation::LatencyMeter> meter;
  if (options.timecode) {
    display.emplace(world.file());
    camera.see(&*display);
    meter.emplace(evaluation::LatencySettings{.exposure = seconds(world.file().camera.exposure_s),
                                              .scan_out = options.graphics.scan_out,
                                              .readout = seconds(config::readout_s(world.file()))});
  }
  auto player = desktop::ScriptedUser::make(options.applications, scene, rig, world.file(), options.seed,
                                            options.player_extra_delay_s);
  if (!player) return tl::unexpected(player.error());
  if (auto asked = world.person().ask({device::Gesture::look, "", 0}); !asked)
    return tl::unexpected(asked.error());

  LockstepResult result;
  const Instant<TrueTime> start = world.now();
  const double total = options.warm_up_s + options.seconds;
  std::optional<Instant<TrueTime>> finish_at;
  std::uint64_t last_impact = 0;
  std::vector<double> impact_times;
  constexpr Duration kTick = std::chrono::milliseconds(1);
  bool playing = false;
  haptics::HapticStatistics before_play;
  physics.control(scene::Control::pause);  // while warming up the haptic loop hears of a world at rest

  for (Instant<TrueTime> t = start + kTick; to_seconds(t - start) <= total; t += kTick) {
    since = to_seconds(t - start);
    world.advance_to(t);
    const auto now = graphics_time(t);
    const bool counted = to_seconds(t - start) > options.warm_up_s;

    network.advance_to(t);
    if (counted && !playing) {
      playing = true;
      before_play = physics.haptic().statistics();
      physics.control(scene::Control::resume);
    }
    physics.haptic_tick(physics_time(t));
    while (const auto control = (*service)->take_control()) physics.control(*control);
    physics.physics_tick(physics_time(t));
    if (counted && options.watch) options.watch(physics.newest());
    if (!options.pass_on && physics.impact().number != last_impact) {
      last_impact = physics.impact().number;
      impact_times.push_back(physics.impact().start.seconds());
    }

    if (meter) {
      const Duration code = now.since_epoch % device::kTimecodeCycle;
      display->show(t, code);
      meter->timecode_shown(now, code);
    }
    camera.close(to_seconds(t - start) < options.warm_up_s - kOpenBefore);
    graphics.service(now);
    if (options.conditions) options.conditions(since, graphics.conditions());
    if (!graphics.frame_begun() && graphics.begin_frame(now)) finish_at = t + options.drawing_time;
    if (finish_at && t >= *finish_at) {
      finish_at.reset();
      const server::graphics::FrameRecord& record = graphics.finish_frame(now);
      evaluation::PlayedFrame played;
      const bool known = camera.truth_of(record.camera_frame, played);
      if (record.picture_time == server::graphics::PictureTime::predicted) {
        // Its light leaves the display now, where scanning out takes no time.
        played.truth.X_world_camera = world.true_camera_at(t + options.graphics.scan_out);
        played.true_tip = world.true_state().X_world_tip.translation;
      }
      if (record.right)
        played.right_truth = evaluation::CameraView{
            world.truth().right_lens, played.truth.X_world_camera * world.truth().X_marker_camera.inverse() *
                                          world.truth().X_marker_right_camera};
      player->show(record, graphics);
      if (counted && meter) {
        const auto taken = world.camera_clock().true_time(record.stamp);
        if (const auto delay = meter->look(graphics.finished_image(), record, now))
          result.delays.push_back({*delay, t + seconds(world.file().display.scan_out_s) - taken});
        else
          ++result.timecodes_unread;
      }
      if (counted && record.have_state && known) {
        if (pictures.shown) pictures.shown(record);
        played.record = record;
        played.shown_tip = scene::shown_tip(record.state, scene);
        played.record.rgb = {};  // an emptied one would keep its megabyte
        const auto& model = graphics.sync().model();
        const double sync_error_s = to_seconds(model.to(now) - physics_time(t));
        if (options.pass_on) {
          options.pass_on({.played = played,
                           .sync_error_s = sync_error_s,
                           .sync_uncertainty_s = to_seconds(model.uncertainty(now)),
                           .round_trips_s = graphics.take_round_trips()});
        } else {
          result.frames.push_back(std::move(played));
          result.sync_errors_s.push_back(sync_error_s);
        }
      }
      if (progress) progress(to_seconds(t - start) / total);
    }
    player->act(now, graphics, world.hand());

    // The loop keeps five seconds; take what belongs to impacts every second.
    if (!options.pass_on &&
        ((t - start).count() % 1'000'000'000 == 0 || t + kTick > start + seconds(total))) {
      const double from = result.haptics.empty() ? 0.0 : result.haptics.back().time.seconds();
      for (const auto& r : physics.haptic().records()) {
        const double at = r.time.seconds();
        if (at <= from) continue;
        // A lasting force is no impact: kept while it is asked for.
        const bool lasting = impact_times.empty() && counted && r.requested != Vector3::Zero();
        const bool near_impact = std::any_of(impact_times.begin(), impact_times.end(), [at](double impact) {
          return at >= impact - kImpactBefore && at <= impact + kImpactAfter;
        });
        if (near_impact || lasting) result.haptics.push_back(r);
      }
    }
  }
  result.haptic = physics.haptic().statistics();
  result.haptic.ticks -= before_play.ticks;
  result.haptic.limited_ticks -= before_play.limited_ticks;
  result.haptic.peak_limited_ticks -= before_play.peak_limited_ticks;
  result.haptic.fault_ticks -= before_play.fault_ticks;
  result.haptic.bad_samples -= before_play.bad_samples;
  result.exchange = link->counters();
  result.final_state = physics.newest();
  result.round_trips_s = graphics.take_round_trips();
  return result;
}

}  // namespace palpate::sim::lockstep
