#include "palpate/system/lockstep_play.h"

#include <algorithm>

#include "palpate/applications/applications.h"
#include "palpate/physics_server/physics_server.h"
#include "palpate/system/player_seat.h"

namespace palpate {
namespace {

// Haptic records are kept from this long before a blow's start to this long after it.
constexpr double kBlowBefore = 0.010, kBlowAfter = 0.040;

// The camera's pictures are drawn from this long before the first frame that counts.
constexpr double kOpenBefore = 0.1;

// Keeps what the camera saw of the truth, and passes the view on to whoever draws it.
class WatchedCamera {
 public:
  WatchedCamera(sim::SimWorld& world, sim::RenderView render) : world_(world), render_(std::move(render)) {
    world_.set_renderer([this](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
      views_.push_back(view);
      if (closed_)
        rgb.assign(3 * static_cast<std::size_t>(view.lens.width) * static_cast<std::size_t>(view.lens.height),
                   0);
      else if (render_)
        render_(view, rgb);
    });
  }
  ~WatchedCamera() { world_.set_renderer(render_); }
  void forget() { views_.clear(); }
  // While closed its images are black: nothing is drawn that nobody looks at.
  void close(bool closed) { closed_ = closed; }
  bool has_view() const { return !views_.empty(); }
  // A rolling shutter gives one view per band; the stamp is that of the middle.
  const sim::TrueView& view() const { return views_[views_.size() / 2]; }

 private:
  sim::SimWorld& world_;
  sim::RenderView render_;
  std::vector<sim::TrueView> views_;
  bool closed_ = false;
};

Vector3 true_tip(const sim::TrueView& view) {
  return (view.X_world_base * phantom_tip(view.theta, view.lengths)).m;
}

}  // namespace

Vector3 shown_tip(const WorldState& state, const SceneDescription& scene) {
  const auto& bat = state.bodies[kCarried];
  return bat.p() - bat.q() * scene.bat_offset;
}

Expected<LockstepResult> play_in_lockstep(sim::SimWorld& world, const Rig& rig, const SceneDescription& scene,
                                          const LockstepOptions& options, const LockstepPictures& pictures,
                                          const std::function<void(double)>& progress) {
  if (!rig.arm || !rig.camera || !rig.hand_eye)
    return refused("play: the rig is not calibrated; run `palpate calibrate all`");
  auto application = make_application(scene, options.seed);
  if (!application) return tl::unexpected(application.error());

  // The physics host's clock is the reference: it reads true time.
  const auto physics_time = [](Instant<TrueTime> t) { return Instant<PhysicsClock>{t.since_epoch}; };
  const auto graphics_time = [&world](Instant<TrueTime> t) { return world.graphics_clock().at(t); };

  HapticSettings haptic_settings;
  haptic_settings.limits = force_limits_of(rig.arm->model);
  PhysicsServer physics(rig, scene, std::move(*application), world.arm(), haptic_settings);
  InProcessNetwork network(options.channel, options.seed, physics_time, graphics_time);
  network.advance_to(world.now());
  auto service = network.serve([&physics](Instant<PhysicsClock> t) { return physics.state_at(t); }, scene);
  if (!service) return tl::unexpected(service.error());
  auto link = network.connect();
  WatchedCamera camera(world, pictures.camera);
  GraphicsServer graphics(rig, *link, world.tracker(), world.camera(), pictures.refiner, pictures.painter);
  auto player = PlayerSeat::seat(scene, rig, world.file(), options.seed, options.player_extra_delay_s);
  if (!player) return tl::unexpected(player.error());
  if (auto asked = world.person().ask({Gesture::look, "", 0}); !asked) return tl::unexpected(asked.error());

  LockstepResult result;
  const Instant<TrueTime> start = world.now();
  const double total = options.warm_up_s + options.seconds;
  std::optional<Instant<TrueTime>> finish_at;
  std::optional<PlayedFrame> open;
  std::uint64_t last_blow = 0;
  std::vector<double> blow_times;
  constexpr Duration kTick = std::chrono::milliseconds(1);
  bool playing = false;
  HapticStatistics before_play;
  physics.control(Control::pause);  // while warming up the haptic loop hears of a world at rest

  for (Instant<TrueTime> t = start + kTick; to_seconds(t - start) <= total; t += kTick) {
    world.advance_to(t);
    const auto now = graphics_time(t);
    const bool counted = to_seconds(t - start) > options.warm_up_s;

    network.advance_to(t);
    if (counted && !playing) {
      playing = true;
      before_play = physics.haptic().statistics();
      physics.control(Control::resume);
    }
    physics.haptic_tick(physics_time(t));
    while (const auto wish = (*service)->take_control()) physics.control(*wish);
    physics.physics_tick(physics_time(t));
    if (counted && options.watch) options.watch(physics.newest());
    if (!options.pass_on && physics.contact().number != last_blow) {
      last_blow = physics.contact().number;
      blow_times.push_back(physics.contact().start.seconds());
    }

    camera.forget();
    camera.close(to_seconds(t - start) < options.warm_up_s - kOpenBefore);
    graphics.service(now);
    if (!graphics.frame_begun() && graphics.begin_frame(now)) {
      finish_at = t + options.drawing_time;
      open.reset();
      if (camera.has_view()) {
        open = PlayedFrame{};
        open->truth = {camera.view().lens, camera.view().X_world_camera};
        open->true_tip = true_tip(camera.view());
      }
    }
    if (finish_at && t >= *finish_at) {
      finish_at.reset();
      const FrameRecord& record = graphics.finish_frame(now);
      player->show(record, graphics);
      if (counted && record.have_state && open) {
        if (pictures.shown) pictures.shown(record);
        open->record = record;
        open->record.rgb.clear();
        const auto& model = graphics.sync().model();
        const double sync_error_s = to_seconds(model.to(now) - physics_time(t));
        if (options.pass_on) {
          options.pass_on({.played = *open,
                           .sync_error_s = sync_error_s,
                           .sync_uncertainty_s = to_seconds(model.uncertainty(now)),
                           .round_trips_s = graphics.take_round_trips()});
        } else {
          result.frames.push_back(std::move(*open));
          result.sync_errors_s.push_back(sync_error_s);
        }
      }
      open.reset();
      if (progress) progress(to_seconds(t - start) / total);
    }
    player->act(now, graphics, world.hand());

    // The loop keeps five seconds; take what belongs to blows every second.
    if (!options.pass_on &&
        ((t - start).count() % 1'000'000'000 == 0 || t + kTick > start + seconds(total))) {
      const double from = result.haptics.empty() ? 0.0 : result.haptics.back().time.seconds();
      for (const auto& r : physics.haptic().records()) {
        const double at = r.time.seconds();
        if (at <= from) continue;
        // A lasting force is no blow: kept while it is asked for.
        const bool lasting = blow_times.empty() && counted && r.asked != Vector3::Zero();
        const bool near_blow = std::any_of(blow_times.begin(), blow_times.end(), [at](double blow) {
          return at >= blow - kBlowBefore && at <= blow + kBlowAfter;
        });
        if (near_blow || lasting) result.haptics.push_back(r);
      }
    }
  }
  result.haptic = physics.haptic().statistics();
  result.haptic.ticks -= before_play.ticks;
  result.haptic.limited_ticks -= before_play.limited_ticks;
  result.haptic.fault_ticks -= before_play.fault_ticks;
  result.haptic.bad_samples -= before_play.bad_samples;
  result.exchange = link->counters();
  result.final_state = physics.newest();
  result.round_trips_s = graphics.take_round_trips();
  return result;
}

}  // namespace palpate
