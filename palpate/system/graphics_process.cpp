#include "palpate/system/graphics_process.h"

#include <algorithm>
#include <deque>
#include <map>
#include <thread>

#include "palpate/applications/applications.h"
#include "palpate/applications/touched_mesh.h"
#include "palpate/core/csv.h"
#include "palpate/core/csv_file.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/devices/lab_channel.h"
#include "palpate/draw/context.h"
#include "palpate/network/zmq_engine.h"
#include "palpate/system/demo_raw.h"
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

// Tells once that the physics server has gone, and once that it is back.
class ServerWatch {
 public:
  struct Change {
    Instant<GraphicsClock> time;
    bool there = false;
  };

  ServerWatch(const StateLink& link, const Clock<GraphicsClock>& clock, std::string address,
              const std::function<void(const std::string&)>& say)
      : link_(link), clock_(clock), address_(std::move(address)), say_(say) {}
  void look() {
    if (link_.refusal() != refusal_) {
      refusal_ = link_.refusal();
      if (say_ && refusal_)
        say_(
            fmt::format("graphics: the physics server at {} refuses: {}", address_, excerpt(*refusal_, 200)));
    }
    if (link_.peer_alive() == there_) return;
    there_ = !there_;
    changes_.push_back({clock_.now(), there_});
    if (changes_.size() > 1000) changes_.pop_front();
    if (say_)
      say_(there_ ? fmt::format("graphics: the physics server at {} answers again", address_)
                  : absence() + "; drawing goes on with the last state");
  }
  bool there() const { return there_; }
  // The latest, should a server come and go for days.
  const std::deque<Change>& changes() const { return changes_; }
  std::string absence() const {
    return fmt::format("graphics: the physics server at {} no longer answers; start `palpate physics` again",
                       address_);
  }

 private:
  const StateLink& link_;
  const Clock<GraphicsClock>& clock_;
  std::string address_;
  const std::function<void(const std::string&)>& say_;
  bool there_ = true;
  std::deque<Change> changes_;
  std::optional<std::string> refusal_;
};

// Tells each time the physics server's clock was found stepped or stopped.
class ClockWatch {
 public:
  explicit ClockWatch(const std::function<void(const std::string&)>& say) : say_(say) {}
  void look(const ClockSync<GraphicsClock, PhysicsClock>& sync) {
    if (sync.restarts() == restarts_) return;
    restarts_ = sync.restarts();
    if (say_)
      say_(
          "graphics: the physics server's clock was set, or stood still for a while; the clocks are "
          "synchronised anew");
  }

 private:
  const std::function<void(const std::string&)>& say_;
  int restarts_ = 0;
};

// Tells each time a condition begins, finds other words, or ends.
class ConditionTeller {
 public:
  explicit ConditionTeller(const std::function<void(const std::string&)>& say) : say_(say) {}
  void look(const std::vector<Condition>& now) {
    for (const auto& condition : now) {
      const Condition* before = among(told_, condition.kind);
      if (before == nullptr) ++begun_[name_of(condition.kind)];
      if (say_ && (before == nullptr || before->text != condition.text)) say_("graphics: " + condition.text);
    }
    for (const auto& condition : told_)
      if (say_ && among(now, condition.kind) == nullptr)
        say_(fmt::format("graphics: {}", end_of(condition.kind)));
    told_ = now;
  }
  // How often each has begun.
  const std::map<std::string, int>& begun() const { return begun_; }

 private:
  static const Condition* among(const std::vector<Condition>& conditions, ConditionKind kind) {
    const auto at =
        std::find_if(conditions.begin(), conditions.end(), [kind](const auto& c) { return c.kind == kind; });
    return at == conditions.end() ? nullptr : &*at;
  }
  const std::function<void(const std::string&)>& say_;
  std::vector<Condition> told_;
  std::map<std::string, int> begun_;
};

// The server of a rig with a board asks nobody: the picture says where the camera is.
class NoTracker : public TrackerDevice {
 public:
  std::vector<TrackerSample> poll() override { return {}; }
};

// For `palpate status`.
ClientFigures figures_of(std::uint64_t frames, std::uint64_t late, std::uint64_t lost, double elapsed_s,
                         const JitterHistogram& trips, const GraphicsServer& server,
                         Instant<GraphicsClock> now) {
  ClientFigures figures{.frames = frames,
                        .late = late,
                        .lost = lost,
                        .rate_hz = elapsed_s > 0.0 ? static_cast<double>(frames) / elapsed_s : 0.0,
                        .round_trip_median_us = 1e6 * to_seconds(trips.quantile(0.5)),
                        .round_trip_p99_us = 1e6 * to_seconds(trips.quantile(0.99))};
  for (const auto& condition : server.conditions()) figures.conditions.push_back(condition.text);
  const auto& sync = server.sync();
  if (sync.exchanges() > 0) {
    figures.clock_offset_s = 1e-9 * static_cast<double>(sync.model().to(now).ns() - now.ns());
    figures.clock_uncertainty_us = 1e6 * to_seconds(sync.model().uncertainty(now));
  }
  return figures;
}

// Quantiles of durations in bounded memory: exact for a run of minutes, to 1/16 of the value from then on.
class Quantiles {
 public:
  Quantiles() { first_.reserve(kExact); }
  void add(Duration d) {
    if (first_.size() < kExact) first_.push_back(to_seconds(d) * 1e6);
    all_.add(d);
  }
  double us(double share) const {
    if (all_.count() > kExact) return to_seconds(all_.quantile(share)) * 1e6;
    ErrorSummary summary;
    for (const double v : first_) summary.add(v);
    return summary.quantile(share);
  }
  const JitterHistogram& histogram() const { return all_; }

 private:
  static constexpr std::size_t kExact = 4096;
  std::vector<double> first_;
  JitterHistogram all_;
};

// Written as it goes: a server may run for days.
struct Logs {
  CsvFile frames, sync;

  static Expected<Logs> begin(const std::filesystem::path& folder) {
    // From `unsent` on: how many since the start.
    auto frames = CsvFile::begin(folder / "realtime_frames.csv",
                                 {"frame", "time_s", "round_trip_us", "late", "answer", "landmarks_used",
                                  "busy_us", "unsent", "lost", "repeated", "out_of_order"});
    if (!frames) return tl::unexpected(frames.error());
    auto sync = CsvFile::begin(folder / "realtime_sync.csv",
                               {"time_s", "offset_error_us", "uncertainty_us", "offset_s"});
    if (!sync) return tl::unexpected(sync.error());
    return Logs{std::move(*frames), std::move(*sync)};
  }
  Expected<void> finish() {
    auto done = frames.finish();
    return done ? sync.finish() : done;
  }
};

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
  std::shared_ptr<LabClient> lab;  // none where nothing of it is used
  const bool on_board = options.rig.board.has_value();
  if ((!options.tracker && !on_board) || !options.camera || options.player || options.mouse) {
    auto client = LabClient::open(options.lab);
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
  std::unique_ptr<LabCamera> lab_camera;
  std::unique_ptr<cameras::LiveCamera> live_camera;
  if (options.camera) {
    cameras::Wish wish = *options.camera;
    wish.settings.width = options.rig.camera->model.width;
    wish.settings.height = options.rig.camera->model.height;
    auto opened = cameras::open_camera(wish);
    if (!opened) return tl::unexpected(opened.error());
    live_camera = std::move(*opened);
  } else {
    auto opened = LabCamera::open(lab);
    if (!opened) return tl::unexpected(opened.error());
    lab_camera = std::move(*opened);
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
  if (options.window) {
    auto opened = WindowSeat::open(scene, options.rig, options.world, *place,
                                   {.mouse = options.mouse,
                                    .scripted_player = options.player,
                                    .clock_strip = options.clock_strip && live_camera});
    if (!opened) return tl::unexpected(opened.error());
    seat = std::move(*opened);
    if (options.notice && !seat->notice().empty()) options.notice("graphics: " + seat->notice());
  }

  std::unique_ptr<PhotonProbe> photons;
  if (options.clock_strip) {
    const double exposure_s = live_camera ? live_camera->facts().exposure_s : options.world.camera.exposure_s;
    auto opened = PhotonProbe::open(live_camera ? nullptr : lab,
                                    {.exposure = seconds(exposure_s), .scan_out = options.graphics.scan_out},
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
  std::optional<TrackerWatch> tracker_watch;
  if (live_tracker) tracker_watch.emplace(*live_tracker, *options.tracker, clock.now());
  ServerWatch physics(**link, clock, endpoint.address, options.notice);
  ClockWatch clocks(options.notice);
  ConditionTeller conditions(options.notice);
  std::optional<Logs> logs;
  if (!options.out.empty()) {
    auto begun_logs = Logs::begin(options.out);
    if (!begun_logs) return tl::unexpected(begun_logs.error());
    logs.emplace(std::move(*begun_logs));
  }
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
    conditions.look(server.conditions());
    if (tracker_watch)
      if (const auto news = tracker_watch->look(clock.now()); news && options.notice) options.notice(*news);
    if (!server.frame_begun()) {
      if (server.begin_frame(clock.now())) draw_at = clock.now() + kDrawAfter;
    } else if (clock.now() >= draw_at) {
      const FrameRecord& frame = server.finish_frame(clock.now());
      ++frames;
      late += frame.late ? 1 : 0;
      if (player) player->show(frame, server);
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
      if (logs) {
        const auto& so_far = (*link)->counters();
        logs->frames.row(std::vector<std::string>{
            number_text(static_cast<double>(frame.number)), number_text(t),
            trip_us > 0 ? number_text(trip_us) : "", frame.late ? "1" : "0", answer_name(frame.answer),
            number_text(frame.landmarks_used), number_text(to_seconds(clock.now() - frame.begun) * 1e6),
            fmt::format("{}", so_far.unsent), fmt::format("{}", so_far.lost),
            fmt::format("{}", so_far.duplicated), fmt::format("{}", so_far.out_of_order)});
      }
      if (server.sync().exchanges() > 0) {
        // The physics host's clock is this machine's own, undisguised: that is the truth to compare with.
        const auto here = clock.now();
        const double error_us =
            static_cast<double>(server.sync().model().to(here).ns() - clock.to_monotonic(here)) * 1e-3;
        const Duration stated = server.sync().model().uncertainty(here);
        sync_errors.add(seconds(std::abs(error_us) * 1e-6));
        uncertainties.add(stated);
        if (logs)
          logs->sync.row(std::vector<double>{t, error_us, to_seconds(stated) * 1e6,
                                             to_seconds(server.sync().model().offset(here))});
      }
      if (photons) photons->look(server, frame, presented);
    }
    // Also while no images come: then above all it is asked what is wrong.
    if (!told || clock.now() - *told >= StateLink::kHelloEvery) {
      told = clock.now();
      (*link)->tell(figures_of(frames, late, (*link)->counters().lost, to_seconds(*told - begun),
                               trips.histogram(), server, *told));
    }
    if (seat) {
      const auto at = clock.now();
      const auto at_physics =
          server.sync().exchanges() > 0 ? std::optional(server.sync().model().to(at)) : std::nullopt;
      quit = !seat->act(at, **link, hand.get(), server.conditions(), at_physics);
    }
    if (seat && photons)
      if (const auto strip = seat->take_strip()) photons->shown(*strip);
    if (player && !(seat && seat->person_plays())) player->act(clock.now(), server, *hand);
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
