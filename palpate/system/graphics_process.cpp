#include "palpate/system/graphics_process.h"

#include <algorithm>
#include <thread>

#include "palpate/applications/applications.h"
#include "palpate/applications/touched_mesh.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/devices/lab_channel.h"
#include "palpate/draw/context.h"
#include "palpate/network/zmq_engine.h"
#include "palpate/system/graphics_figures.h"
#include "palpate/system/graphics_watches.h"
#include "palpate/system/photon_probe.h"
#include "palpate/system/picture_parts.h"
#include "palpate/system/player_seat.h"
#include "palpate/system/pose_feed.h"
#include "palpate/system/window_seat.h"
#include "palpate/time/real_time.h"

namespace palpate {
namespace {

// How long a physics server may take to answer for the first time before the wait is given up.
constexpr double kPatienceS = 10.0;

// Drawing begins this long after an image was taken up, whether the reply has come or not: the loop goes on
// meanwhile, and a frame of 33 ms does not miss it.
constexpr Duration kDrawAfter = std::chrono::milliseconds(2);

// The server of a rig with a board asks nobody: the picture says where the camera is.
class NoTracker : public TrackerDevice {
 public:
  std::vector<TrackerSample> poll() override { return {}; }
};

// Set to the size that was calibrated.
Expected<std::unique_ptr<cameras::LiveCamera>> open_for(cameras::Wish wish,
                                                        const CameraCalibration& calibrated) {
  wish.settings.width = calibrated.model.width;
  wish.settings.height = calibrated.model.height;
  return cameras::open_camera(wish);
}

double camera_readout_s(const GraphicsProcessOptions& options) {
  if (!options.camera) return sim::readout_s(options.world);
  return options.camera->settings.rolling ? options.camera->settings.readout_s : 0.0;
}

}  // namespace

Expected<Json> run_graphics_process(const GraphicsProcessOptions& options) {
  const auto& stop = stop_requested();
  keep_freed_memory();
  if (options.window)  // known now, not after waiting for a physics server
    if (auto possible = window::Window::possible(); !possible) return tl::unexpected(possible.error());
  const auto drawing = draw::Context::of_this_thread();  // the same; kept for those who draw
  if (!drawing) return refused("graphics: {}", drawing.error().message);
  const auto place = server_place(options.server);
  if (!place) return tl::unexpected(place.error());
  const Endpoint& endpoint = place->endpoint;
  // Real cameras before the laboratory that stands in for the rest: who names one wants to hear of it.
  std::unique_ptr<cameras::LiveCamera> live_camera, live_right;
  // The right one first: of two recordings the left one must not run ahead.
  if (options.right_camera) {
    auto opened = open_for(*options.right_camera, *options.rig.right_camera);
    if (!opened) return tl::unexpected(opened.error());
    live_right = std::move(*opened);
  }
  if (options.camera) {
    auto opened = open_for(*options.camera, *options.rig.camera);
    if (!opened) return tl::unexpected(opened.error());
    live_camera = std::move(*opened);
  }
  std::shared_ptr<LabClient> lab;  // none where nothing of it is used
  const bool on_board = options.rig.board.has_value();
  if ((!options.tracker && !on_board) || !options.camera || options.player || options.mouse) {
    auto client = LabClient::open(options.lab);
    if (!client && options.camera && !options.tracker && !on_board)
      return refused("{}, or name a real tracker (--tracker igtl://HOST:PORT)", client.error().message);
    if (!client) return tl::unexpected(client.error());
    lab = std::move(*client);
  }
  std::unique_ptr<TrackerDevice> lab_tracker;
  std::unique_ptr<igtl::OpenIgtlinkTracker> live_tracker;
  if (options.tracker) {
    auto opened = open_live_tracker(*options.tracker);
    if (!opened) return tl::unexpected(opened.error());
    live_tracker = std::move(*opened);
  } else if (on_board) {
    lab_tracker = std::make_unique<NoTracker>();
  } else {
    lab_tracker = std::make_unique<LabTracker>(lab);
  }
  TrackerDevice& tracker = live_tracker ? static_cast<TrackerDevice&>(*live_tracker) : *lab_tracker;
  std::optional<PoseFeed> feed;
  if (options.publish) {
    auto opened = PoseFeed::open(
        *options.publish, seconds(options.rig.delays.value_or(DelayCalibration{}).tracker_after_arm_s));
    if (!opened) return tl::unexpected(opened.error());
    feed = std::move(*opened);
  }
  std::unique_ptr<LabCamera> lab_camera, lab_right;
  if (!live_camera) {
    auto opened = LabCamera::open(lab);
    if (!opened) return tl::unexpected(opened.error());
    lab_camera = std::move(*opened);
    if (lab->cameras() > 1 && has_two_eyes(options.rig)) {
      auto second = LabCamera::open(lab, 1);
      if (!second) return tl::unexpected(second.error());
      lab_right = std::move(*second);
    }
  }
  CameraDevice& camera =
      live_camera ? static_cast<CameraDevice&>(*live_camera) : static_cast<CameraDevice&>(*lab_camera);
  std::unique_ptr<LabHand> hand;
  if (options.player || options.mouse) {
    auto opened = LabHand::open(lab);
    if (!opened) return tl::unexpected(opened.error());
    hand = std::move(*opened);
  }
  const MonotonicClock<GraphicsClock> clock(options.disguise_offset_s, options.disguise_drift_ppm,
                                            MonotonicClock<GraphicsClock>::monotonic_ns());
  auto link = connect_states(endpoint, clock, "graphics", place->identity);
  if (!link) return tl::unexpected(link.error());

  // Who is there, and what is played?
  const auto start = clock.now();
  while (!(*link)->description()) {
    (*link)->poll();
    if (stop.load()) return refused("graphics: stopped before the physics server answered");
    if (to_seconds(clock.now() - start) > kPatienceS) {
      if ((*link)->refusal())
        return refused("graphics: the physics server at {} refuses: {}", endpoint.address,
                       excerpt(*(*link)->refusal(), 200));
      const auto trouble = (*link)->trouble();
      if (trouble)
        return refused("graphics: the physics server at {} turns us away: {}", endpoint.address, *trouble);
      return refused(
          "graphics: no physics server answers at {} after {:.0f} s; start `palpate physics` first",
          endpoint.address, kPatienceS);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  SceneDescription scene = *(*link)->description();
  if (auto read = find_touched_mesh(scene, options.mesh, endpoint.local()); !read)
    return tl::unexpected(read.error());
  auto artist = make_artist(scene);
  if (!artist) return tl::unexpected(artist.error());
  PictureParts pictures(options.rig, scene, std::move(*artist), options.quality);
  GraphicsServer server(options.rig, **link, tracker, camera, pictures.refiner(),
                        pictures.painter(!options.window), options.graphics);
  server.predict_with(pictures.predictor());
  if (lab_right) server.add_right_camera(*lab_right, true);
  // Stamps of GenICam cameras are each camera's own.
  if (live_right)
    server.add_right_camera(*live_right, options.right_camera->choice.kind != cameras::Kind::aravis);
  if (on_board) server.find_pose_with(pictures.finder());
  if (feed)
    server.tap_markers([&feed](MarkerId marker, const MarkerPose& pose) { feed->marker(marker, pose); });
  std::optional<PlayerSeat> player;
  if (options.player) {
    auto seated = PlayerSeat::seat(scene, options.rig, options.world, options.seed);
    if (!seated) return tl::unexpected(seated.error());
    player.emplace(std::move(*seated));
  }
  std::unique_ptr<WindowSeat> seat;
  const auto from_outside = [&pictures](const FrameRecord& frame) -> const OutsidePicture& {
    return pictures.outside(frame);
  };
  if (options.window) {
    auto opened = WindowSeat::open(scene, options.rig, options.world, *place,
                                   {.mouse = options.mouse,
                                    .scripted_player = options.player,
                                    .clock_strip = options.clock_strip && live_camera,
                                    .biocular = options.biocular,
                                    .two_eyes = lab_right != nullptr || live_right != nullptr,
                                    .outside = from_outside,
                                    .outside_eye = pictures.outside_eye()});
    if (!opened) return tl::unexpected(opened.error());
    seat = std::move(*opened);
    if (options.notice && !seat->notice().empty()) options.notice("graphics: " + seat->notice());
  }

  std::unique_ptr<MonitorSeat> monitor;
  if (seat && options.monitor) {
    auto opened = MonitorSeat::open(*options.monitor, seat->window(), from_outside);
    if (!opened) return tl::unexpected(opened.error());
    monitor = std::move(*opened);
  }
  Json monitored;

  std::unique_ptr<PhotonProbe> photons;
  if (options.clock_strip) {
    const double exposure_s = live_camera ? live_camera->facts().exposure_s : options.world.camera.exposure_s;
    auto opened = PhotonProbe::open(live_camera ? nullptr : lab,
                                    {.exposure = seconds(exposure_s),
                                     .scan_out = options.graphics.scan_out,
                                     .readout = seconds(camera_readout_s(options))},
                                    clock, options.out, options.notice);
    if (!opened) return tl::unexpected(opened.error());
    photons = std::move(*opened);
  }

  if (options.notice && !endpoint.local() && !endpoint.encrypted)
    options.notice(fmt::format("graphics: warning: {} is neither encrypted nor guarded", endpoint.address));
  if (options.notice)
    options.notice(
        fmt::format("graphics: shows {} of the physics server at {}", scene.application, endpoint.address));
  if (options.notice && feed)
    options.notice(fmt::format("graphics: publishes poses over OpenIGTLink at {}", feed->address().text()));
  if (options.notice && live_camera)
    options.notice(fmt::format("graphics: camera {}: {}", live_camera->name(),
                               cameras::description(live_camera->facts())));
  if (options.notice && live_right)
    options.notice(fmt::format("graphics: right camera {}: {}", live_right->name(),
                               cameras::description(live_right->facts())));
  if (live_tracker) server.tracker_explains([&] { return why_unheard(*live_tracker, *options.tracker); });
  ServerWatch physics(**link, clock, endpoint.address, options.notice);
  ClockWatch clocks(options.notice);
  ConditionTeller conditions(options.notice);
  std::optional<GraphicsLogs> logs;
  if (!options.out.empty()) {
    auto begun_logs = GraphicsLogs::begin(options.out);
    if (!begun_logs) return tl::unexpected(begun_logs.error());
    logs.emplace(std::move(*begun_logs));
  }
  if (seat && options.mouse) seat->lead(*hand, clock);
  Quantiles trips, sync_errors, uncertainties;
  std::optional<Instant<GraphicsClock>> told;
  std::uint64_t frames = 0, late = 0;
  const auto begun = clock.now();
  auto next = begun;
  auto draw_at = begun;
  bool quit = false;
  const auto goes_on = [&] {
    if (stop.load() || quit) return false;
    return options.seconds <= 0.0 || to_seconds(clock.now() - begun) < options.seconds ||
           (seat && seat->attended());
  };
  while (goes_on()) {
    // A millisecond's rhythm: often enough for arrival times, cheap enough to leave the core to others.
    next += std::chrono::milliseconds(1);
    const auto now = clock.now();
    if (next < now) next = now;
    std::this_thread::sleep_for(next - now);
    if (lab)
      if (auto alive = lab->check(); !alive) return refused("graphics: {}", alive.error().message);
    if (live_camera) server.camera_says(live_camera->trouble());
    server.service(clock.now());
    physics.look();
    clocks.look(server.sync());
    if (conditions.look(server.conditions())) told.reset();  // whoever asks for the status hears of it now
    if (!server.frame_begun()) {
      if (server.begin_frame(clock.now())) draw_at = clock.now() + kDrawAfter;
    } else if (clock.now() >= draw_at) {
      const FrameRecord& frame = server.finish_frame(clock.now());
      ++frames;
      late += frame.late ? 1 : 0;
      if (player && !(seat && seat->person_plays())) player->show(frame, server);
      if (seat)
        seat->show(frame, frame.have_state ? pictures.captions(frame.state) : std::vector<std::string>{},
                   clock.now());
      const auto presented = clock.now();
      if (seat && photons)
        if (const auto strip = seat->take_strip()) photons->shown(*strip);
      if (feed) feed->frame(frame, scene, server.sync().model());
      double trip_us = 0.0;
      for (double s : server.take_round_trips()) {
        trip_us = s * 1e6;
        trips.add(seconds(s));
      }
      const double t = to_seconds(clock.now() - begun);
      if (logs) logs->frame(frame, t, trip_us, clock.now() - frame.begun, (*link)->counters());
      if (logs) logs->poses.add(frame, scene, t);
      if (server.sync().exchanges() > 0) {
        // The physics host's clock is this machine's own, undisguised: that is the truth to compare with.
        const auto here = clock.now();
        const double error_us =
            static_cast<double>(server.sync().model().to(here).ns() - clock.to_monotonic(here)) * 1e-3;
        const Duration stated = server.sync().model().uncertainty(here);
        sync_errors.add(seconds(std::abs(error_us) * 1e-6));
        uncertainties.add(stated);
        if (logs) logs->clocks(t, error_us, stated, server.sync().model().offset(here));
      }
      if (photons) photons->look(server, frame, presented);
      if (monitor)
        monitor->show({frame, seat->from_outside(), seat->content()}, options.rig.camera->model.width, clock);
    }
    // Also while no images come: then above all it is asked what is wrong.
    if (!told || clock.now() - *told >= StateLink::kHelloEvery) {
      told = clock.now();
      (*link)->tell(figures_of(frames, late, (*link)->counters().lost, to_seconds(*told - begun),
                               trips.histogram(), server, *told));
    }
    if (seat) quit = !seat->act(clock.now(), **link, server.conditions(), server.sync());
    if (seat && photons)
      if (const auto strip = seat->take_strip()) photons->shown(*strip);
    if (monitor && !monitor->act(seat->content(), clock.now())) {
      if (options.notice) options.notice("graphics: the monitor window is closed; the play goes on");
      monitored = monitor->figures();
      monitor.reset();
    }
    if (player && !(seat && seat->person_plays())) {
      if (const auto left = seat ? seat->take_left() : std::nullopt)
        player->take_over(*left, clock.now(), server);
      player->act(clock.now(), server, *hand);
    }
  }
  // Figures of a measured run without its server would be figures of something else.
  if (!physics.there() && options.seconds > 0.0 && !stop.load() && !quit)
    return refused("{}", physics.absence());
  const double elapsed = to_seconds(clock.now() - begun);
  const auto& counters = (*link)->counters();
  Json result;
  result["exchange"] = {{"round_trip_us", {{"median", trips.us(0.5)}, {"p99", trips.us(0.99)}}},
                        {"frames", frames},
                        {"late", late},
                        {"lost", counters.lost},
                        {"unsent", counters.unsent},
                        {"repeated", counters.duplicated},
                        {"out_of_order", counters.out_of_order}};
  result["sync"] = {{"offset_error_us_p99", sync_errors.us(0.99)},
                    {"uncertainty_us", uncertainties.us(0.5)},
                    {"exchanges", server.sync().exchanges()},
                    {"restarts", server.sync().restarts()}};
  result["graphics"] = {{"rate_hz", elapsed > 0 ? static_cast<double>(frames) / elapsed : 0.0}};
  result["graphics"]["eyes"] = lab_right || live_right ? 2 : 1;
  if (lab_right || live_right) result["graphics"]["unpaired"] = server.unpaired();
  result["graphics"]["conditions"] = conditions.begun();
  result["begun_monotonic_ns"] = clock.to_monotonic(begun);
  result["server_there"] = Json::array();
  for (const auto& change : physics.changes())
    result["server_there"].push_back({{"time_s", to_seconds(change.time - begun)}, {"there", change.there}});
  if (photons) result["photon_to_photon"] = photons->figures();
  if (feed) result["published"] = feed->figures();
  if (seat)
    result["window"] = {{"played_by_mouse", seat->person_plays()},
                        {"blows_heard", seat->blows()},
                        {"bounces_heard", seat->bounces()}};
  if (monitor) monitored = monitor->figures();
  if (!monitored.is_null()) result["window"]["monitor"] = monitored;
  if (live_camera) {
    const auto status = live_camera->status();
    result["camera"] = {{"name", live_camera->name()}, {"model", live_camera->facts().model},
                        {"pictures", status.pictures}, {"damaged", status.damaged},
                        {"dropped", status.dropped},   {"times_opened", status.times_opened}};
  }
  if (logs)
    if (auto done = logs->finish(); !done) return tl::unexpected(done.error());
  if (photons)
    if (auto done = photons->finish(); !done) return tl::unexpected(done.error());
  return result;
}

}  // namespace palpate
