#include "palpate/server/session/graphics_process.h"

#include <atomic>
#include <thread>
#include <utility>

#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/evaluation/latency_probe.h"
#include "palpate/render/context.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/server/graphics/frame_trace.h"
#include "palpate/server/graphics/graphics_figures.h"
#include "palpate/server/graphics/pose_feed.h"
#include "palpate/server/graphics/server_watch.h"
#include "palpate/server/graphics/shown_frame.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/server/session/frame_log.h"
#include "palpate/server/session/frame_recorder.h"
#include "palpate/server/session/graphics_screens.h"
#include "palpate/server/session/graphics_side.h"
#include "palpate/server/session/physics_meeting.h"
#include "palpate/time/real_time.h"
#include "palpate/transport/shown_picture.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::server::session {
namespace {

constexpr Log kLog("graphics");

double camera_readout_s(const GraphicsProcessOptions& options) {
  if (!options.camera) return sim::config::readout_s(options.world);
  return options.camera->settings.rolling ? options.camera->settings.readout_s : 0.0;
}

// From opened devices to the last figure. What is opened first is closed last.
class GraphicsProcess {
 public:
  explicit GraphicsProcess(const GraphicsProcessOptions& options)
      : options_(options),
        clock_(options.disguise_offset_s, options.disguise_drift_ppm,
               MonotonicClock<GraphicsClock>::monotonic_ns()) {}

  Expected<Json> run();

 private:
  Expected<void> open();
  Expected<GraphicsDevices> open_devices();
  Expected<void> meet_physics_server();
  Expected<void> begin_record();
  Expected<void> open_screens();
  Expected<void> open_latency_probe();
  Expected<void> open_logs();
  void introduce() const;
  bool goes_on() const;
  std::optional<std::string> unmeasured() const;
  Expected<void> tick();
  bool begin_frame();
  void draw_frame();
  void show_frame();
  void trace_stage(const char* name) {
    if (trace_) trace_->stage(name);
  }
  void trace_frame(const DrawnFrame& drawn, Instant<GraphicsClock> presented);
  void begin_trace();
  Expected<void> finish_trace();
  void tell_figures();
  void take_turns_with_a_person();
  void shown_timecode();
  Json figures() const;
  desktop::DesktopUi* ui() const { return screens_ ? screens_->ui() : nullptr; }
  bool program_plays() const { return options_.player && !(ui() && ui()->person_plays()); }

  const GraphicsProcessOptions& options_;
  const std::atomic<bool>& stop_ = stop_requested();
  std::shared_ptr<render::Context> drawing_;  // kept for those who draw
  transport::ServerPlace place_;
  std::optional<graphics::PoseFeed> feed_;
  std::optional<transport::ShownPictureWriter> console_;  // none: there is no folder for it
  const MonotonicClock<GraphicsClock> clock_;
  std::unique_ptr<record::session::SessionRecording>
      recording_;  // null: nothing is recorded; its devices go first
  std::optional<FrameRecorder> recorder_;
  std::optional<GraphicsDevices> devices_;  // until the physics server has been met
  std::unique_ptr<GraphicsSide> side_;
  std::unique_ptr<GraphicsScreens> screens_;
  std::unique_ptr<evaluation::LatencyProbe> probe_;
  std::optional<graphics::ServerWatch> physics_;
  std::optional<graphics::FrameTrace> trace_;
  std::uint64_t health_told_ = 0;  // changes of which the physics server has heard
  FrameLog log_{clock_};
  std::optional<Instant<GraphicsClock>> told_;
  std::uint64_t frames_ = 0, late_ = 0;
  std::unique_ptr<scene::PlayRecord> played_;  // of the states that pictures showed; null: not known
  Instant<GraphicsClock> begun_, next_, draw_at_;
  std::optional<DrawnFrame> drawn_;  // held
  bool quit_ = false;
};

Expected<Json> GraphicsProcess::run() {
  if (auto done = open(); !done) return tl::unexpected(done.error());
  if (auto done = meet_physics_server(); !done) return tl::unexpected(done.error());
  if (auto done = open_screens(); !done) return tl::unexpected(done.error());
  if (auto done = open_latency_probe(); !done) return tl::unexpected(done.error());
  introduce();
  if (auto done = open_logs(); !done) return tl::unexpected(done.error());
  if (ui() && options_.mouse) ui()->lead(*side_->devices().hand(), clock_);
  if (!options_.trace.empty()) begin_trace();
  begun_ = next_ = draw_at_ = clock_.now();
  log_.set_begun(begun_);
  if (ui() && options_.seconds > 0.0) ui()->set_end(begun_ + seconds(options_.seconds));
  while (goes_on())
    if (auto done = tick(); !done) return tl::unexpected(done.error());
  if (drawn_) show_frame();  // it counts already
  // Figures of a measured run without its server would be figures of something else.
  if (const auto why = unmeasured()) return refused("graphics: {}", *why);
  Json result = figures();
  if (auto done = log_.finish(); !done) return tl::unexpected(done.error());
  if (auto done = screens_->finish(); !done) return tl::unexpected(done.error());
  if (auto done = finish_trace(); !done) return tl::unexpected(done.error());
  if (probe_)
    if (auto done = probe_->finish(); !done) return tl::unexpected(done.error());
  if (recording_) {
    auto recorded = recording_->finish();
    if (!recorded) return recorded;
    result["recording"] = std::move(*recorded);
  }
  return result;
}

Expected<void> GraphicsProcess::open() {
  if (options_.window)  // known now, not after waiting for a physics server
    if (auto possible = desktop::Window::possible(); !possible) return possible;
  if (options_.headset)  // the same
    if (auto found = headset::Headset::look_for(); !found) return tl::unexpected(found.error());
  if (options_.pixels == Pixels::drawn) {  // the same
    auto drawing = render::Context::of_this_thread();
    if (!drawing) return refused("graphics: {}", drawing.error().message);
    drawing_ = std::move(*drawing);
  } else if (options_.window || options_.headset) {
    return wrong_use("graphics: a window or a headset shows drawn pictures, and pixels are not to be drawn");
  }
  auto place = transport::server_place(options_.server);
  if (!place) return tl::unexpected(place.error());
  place_ = std::move(*place);
  auto devices = open_devices();
  if (!devices) return tl::unexpected(devices.error());
  devices_.emplace(std::move(*devices));
  if (const auto folder = run_directory()) console_.emplace(*folder);
  if (options_.publish.empty()) return {};
  auto feed = graphics::PoseFeed::open(
      options_.publish, seconds(options_.rig.delays.value_or(rig::DelayCalibration{}).tracker_after_arm_s));
  if (!feed) return tl::unexpected(feed.error());
  feed_ = std::move(*feed);
  return {};
}

// Where there is a recording, its drivers write into it.
Expected<GraphicsDevices> GraphicsProcess::open_devices() {
  if (options_.record.empty()) return GraphicsDevices::open(options_);
  auto begun =
      record::session::SessionRecording::begin(options_.record, {.recorder = "graphics", .on_error = {}});
  if (!begun) return tl::unexpected(begun.error());
  recording_ = std::move(*begun);
  recording_->record_log();
  recorder_.emplace(*recording_, options_.rig, options_.rig_text, clock_);
  GraphicsSetup setup = options_;
  setup.drivers = record::session::recorded_drivers(options_.drivers, *recording_, options_.record_pictures);
  return GraphicsDevices::open(setup);
}

Expected<void> GraphicsProcess::meet_physics_server() {
  auto link = transport::connect_states(place_.endpoint, clock_, "graphics", place_.identity);
  if (!link) return tl::unexpected(link.error());
  auto scene = await_scene(**link, {"graphics", place_.endpoint.address, options_.wait_s}, clock_, stop_);
  if (!scene) return tl::unexpected(scene.error());
  if (auto same = same_places(options_.rig, *scene, place_.endpoint.address); !same) return same;
  if (options_.applications.find(scene->application) == nullptr)
    kLog.info(
        "application '{}' is not part of this program (--plugin FILE brings it): its bodies are shown as "
        "plain shapes",
        excerpt(scene->application));
  else if (auto found = scene::find_mesh_asset(*scene, options_.mesh, place_.endpoint.local()); !found)
    return found;
  auto side = GraphicsSide::make(options_, std::move(*devices_), std::move(*link), *scene);
  if (!side) return tl::unexpected(side.error());
  side_ = std::move(*side);
  side_->server().set_log(kLog);
  side_->server().set_clock(clock_);
  side_->server().set_drawn(physics::scene_from_rig(options_.rig, *scene));
  if (auto begun = begin_record(); !begun) return begun;
  devices_.reset();
  if (auto* pictures = side_->renderer()) {
    pictures->set_captions(!options_.window && !options_.headset);
    pictures->rehearse();
  }
  if (feed_)
    side_->server().set_marker_tap(
        [this](device::MarkerId marker, const device::MarkerPose& pose) { feed_->marker(marker, pose); });
  return {};
}

// Of the play from now on, where the application is part of this program.
Expected<void> GraphicsProcess::begin_record() {
  if (options_.applications.find(side_->scene().application) == nullptr) return {};
  auto record = options_.applications.make_record(side_->scene());
  if (!record) return tl::unexpected(record.error());
  played_ = std::move(*record);
  return {};
}

Expected<void> GraphicsProcess::open_screens() {
  auto opened = GraphicsScreens::open(options_, *side_, place_, clock_);
  if (!opened) return tl::unexpected(opened.error());
  screens_ = std::move(*opened);
  return {};
}

Expected<void> GraphicsProcess::open_latency_probe() {
  if (!options_.timecode) return {};
  const auto* live = side_->devices().live_camera();
  const double exposure_s = live != nullptr ? live->exposure_s() : options_.world.camera.exposure_s;
  std::unique_ptr<device::OpenedDisplay> display;
  if (live == nullptr) {
    auto found = options_.drivers.open(device::DisplayRequest{options_.stand_in});
    if (!found) return tl::unexpected(found.error());
    display = std::move(*found);
  }
  auto opened = evaluation::LatencyProbe::open(std::move(display),
                                               {.exposure = seconds(exposure_s),
                                                .scan_out = options_.graphics.scan_out,
                                                .readout = seconds(camera_readout_s(options_))},
                                               clock_, options_.out);
  if (!opened) return tl::unexpected(opened.error());
  probe_ = std::move(*opened);
  return {};
}

Expected<void> GraphicsProcess::open_logs() {
  physics_.emplace(side_->link(), place_.endpoint.address);
  if (options_.out.empty()) return {};
  return log_.begin(options_.out, options_.graphics.picture_time, side_->scene());
}

void GraphicsProcess::introduce() const {
  const transport::Endpoint& endpoint = place_.endpoint;
  if (!endpoint.local() && !endpoint.encrypted)
    kLog.warning("warning: {} is neither encrypted nor guarded", endpoint.address);
  kLog.info("shows {} of the physics server at {}", side_->scene().application, endpoint.address);
  if (options_.ready) options_.ready();
  if (feed_) kLog.info("publishes poses over {}", feed_->places());
  if (const auto& arm = options_.rig.arm; arm && arm->model.kind != device::ArmModel::Kind::phantom)
    kLog.info("arm {}: the shape of its links is not known, they hide nothing in the picture",
              arm->model.name);
  if (const auto* camera = side_->devices().live_camera())
    kLog.info("camera {}: {}", camera->name(), camera->description());
  if (const auto* right = side_->devices().live_right())
    kLog.info("right camera {}: {}", right->name(), right->description());
}

bool GraphicsProcess::goes_on() const {
  if (stop_.load() || quit_) return false;
  return options_.seconds <= 0.0 || to_seconds(clock_.now() - begun_) < options_.seconds ||
         (ui() && ui()->attended());
}

// Why a run that was to be measured was none; nothing: it was one, or somebody has ended it.
std::optional<std::string> GraphicsProcess::unmeasured() const {
  if (options_.seconds <= 0.0 || stop_.load() || quit_) return std::nullopt;
  if (!physics_->there()) return physics_->absence();
  for (const auto& condition : side_->server().conditions())
    if (condition.code == device::HealthCode::other_scene) return condition.words;
  return std::nullopt;
}

// A millisecond's rhythm: often enough for arrival times, cheap enough to leave the core to others.
Expected<void> GraphicsProcess::tick() {
  next_ += std::chrono::milliseconds(1);
  const auto now = clock_.now();
  if (next_ < now) next_ = now;
  std::this_thread::sleep_for((drawn_ ? std::min(next_, std::max(now, drawn_->due)) : next_) - now);
  if (auto there = side_->devices().look(); !there) return refused("graphics: {}", there.error().message);
  graphics::GraphicsServer& server = side_->server();
  if (auto* camera = side_->devices().live_camera()) server.set_camera_health(camera->health());
  side_->service(clock_.now());
  physics_->look(server.sync(), clock_.now());
  // Whoever asks for the status hears of it now.
  if (const auto changes = server.health().changes(); changes != health_told_) {
    health_told_ = changes;
    told_.reset();
    if (recorder_) recorder_->write(server.conditions(), clock_.now());
  }
  if (drawn_) {
    if (clock_.now() >= drawn_->due || server.image_waits(clock_.now())) show_frame();
  } else if (begin_frame()) {
    draw_at_ = clock_.now() + GraphicsSide::kDrawAfter;
  } else if (server.frame_begun() && (server.answered() || clock_.now() >= draw_at_)) {
    draw_frame();
  }
  // Also while no images come: then above all it is asked what is wrong.
  if (!told_ || clock_.now() - *told_ >= transport::StateLink::kHelloEvery) tell_figures();
  quit_ = !screens_->act();
  if (ui() && ui()->take_own_game())
    if (auto begun = begin_record(); !begun) return begun;
  shown_timecode();
  screens_->act_for_others();
  take_turns_with_a_person();
  return {};
}

bool GraphicsProcess::begin_frame() {
  if (trace_) trace_->begin(frames_ + 1);
  if (!side_->begin(clock_.now())) return false;
  trace_stage("begun");
  return true;
}

void GraphicsProcess::draw_frame() {
  if (trace_) trace_->begin(frames_ + 1);
  const graphics::FrameRecord& frame = side_->finish(clock_.now(), false);
  if (const auto words = side_->choose_quality(frame, clock_.now())) {
    kLog.write(LogLevel::info, *words);
    screens_->say(*words);
  }
  ++frames_;
  late_ += frame.late ? 1 : 0;
  // Not its pictures: nobody asks for their table here, and it would grow for as long as the server runs.
  if (played_ && frame.have_state) played_->add_state(frame.state);
  trace_stage("drawn");
  const auto ready = clock_.now();
  drawn_ = DrawnFrame{&frame, ready, side_->server().ready(ready)};
  if (drawn_->due <= ready) show_frame();
}

void GraphicsProcess::show_frame() {
  const DrawnFrame drawn = *std::exchange(drawn_, std::nullopt);
  const graphics::FrameRecord& frame = *drawn.frame;
  if (trace_) trace_->begin(frames_);
  if (program_plays() && side_->player()) side_->player()->show(frame, side_->server());
  trace_stage("player");
  screens_->show(frame);
  const auto presented = clock_.now();
  side_->server().shown(presented);
  trace_stage("show");
  shown_timecode();
  if (feed_) feed_->frame(frame, side_->scene(), side_->server().sync().model());
  log_.add(drawn, presented, *side_);
  if (recorder_) recorder_->write(frame, side_->server());
  trace_stage("log");
  if (probe_) probe_->look(side_->server(), frame, presented);
  trace_stage("timecode");
  trace_frame(drawn, presented);
  screens_->show_to_others(frame);
  if (!frame.rgb.empty() && console_ && console_->due())
    console_->write(graphics::shown_picture(frame), frame.rgb);
}

void GraphicsProcess::begin_trace() {
  trace_.emplace();
  if (auto* renderer = side_->renderer())
    renderer->watch_stages([this](const char* stage) { trace_->stage(stage); });
}

// The whole of it, and of that the waits.
void GraphicsProcess::trace_frame(const DrawnFrame& drawn, Instant<GraphicsClock> presented) {
  if (!trace_) return;
  const graphics::FrameRecord& frame = *drawn.frame;
  const auto ns = [this](Instant<GraphicsClock> t) { return clock_.to_monotonic(t); };
  trace_->span("frame", ns(frame.begun), ns(presented));
  trace_->span("image waits", ns(frame.arrived), ns(frame.begun));
  if (drawn.due > drawn.ready) trace_->span("picture held", ns(drawn.ready), ns(drawn.due));
}

Expected<void> GraphicsProcess::finish_trace() {
  if (!trace_) return {};
  if (trace_->log().left_out() > 0)
    kLog.warning("{}: {} spans did not fit", options_.trace.string(), trace_->log().left_out());
  return write_file(options_.trace, trace_->log().json());
}

void GraphicsProcess::tell_figures() {
  told_ = clock_.now();
  side_->link().tell(graphics::figures_of(frames_, late_, side_->link().counters().lost,
                                          to_seconds(*told_ - begun_), log_.trips().histogram(),
                                          side_->server(), *told_));
}

void GraphicsProcess::take_turns_with_a_person() {
  if (!program_plays()) return;
  if (const auto left = ui() ? ui()->take_left() : std::nullopt)
    side_->player()->take_over(*left, clock_.now(), side_->server());
  side_->lead_hand(clock_.now());
}

void GraphicsProcess::shown_timecode() {
  if (!ui() || !probe_) return;
  if (const auto timecode = ui()->take_timecode()) probe_->shown(*timecode);
}

Json GraphicsProcess::figures() const {
  const double elapsed = to_seconds(clock_.now() - begun_);
  Json result;
  result["exchange"] = graphics::exchange_json(log_.trips(), frames_, late_, side_->link().counters());
  const bool two_eyes = side_->devices().right_camera() != nullptr;
  result["graphics"] = {{"rate_hz", elapsed > 0 ? static_cast<double>(frames_) / elapsed : 0.0}};
  result["graphics"]["eyes"] = two_eyes ? 2 : 1;
  if (const auto& quality = side_->quality())
    result["graphics"]["quality"] = {{"at_the_end", render::quality_word(quality->quality())},
                                     {"changes", quality->changes()}};
  if (two_eyes) result["graphics"]["unpaired"] = side_->server().unpaired();
  result["graphics"]["conditions"] = side_->server().health().begun();
  result["begun_monotonic_ns"] = clock_.to_monotonic(begun_);
  result["server_there"] = Json::array();
  for (const auto& change : physics_->changes())
    result["server_there"].push_back({{"time_s", to_seconds(change.time - begun_)}, {"there", change.there}});
  log_.add_figures(result, *side_);
  if (probe_) result["photon_to_photon"] = probe_->figures();
  if (feed_) result["published"] = feed_->figures();
  screens_->add_figures(result);
  if (played_) result["play"] = played_->summary();
  if (const auto* camera = side_->devices().live_camera()) result["camera"] = camera->figures();
  return result;
}

}  // namespace

Expected<Json> run_graphics_process(const GraphicsProcessOptions& options) {
  stop_requested();  // from here on a signal is a request
  keep_freed_memory();
  return GraphicsProcess(options).run();
}

}  // namespace palpate::server::session
