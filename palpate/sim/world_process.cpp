#include "palpate/sim/world_process.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "drivers/laboratory/channel.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/core/trace_log.h"
#include "palpate/device/health_monitor.h"
#include "palpate/sim/device_faults.h"
#include "palpate/sim/exposure_log.h"
#include "palpate/sim/gesture_lines.h"
#include "palpate/sim/simulated_display.h"
#include "palpate/time/real_time.h"

namespace palpate::sim {
namespace {

constexpr Log kLog("world");
constexpr Duration kTick = std::chrono::milliseconds(1);

// Draws the newest shot in a thread of its own, while it is on its way, and publishes it at its arrival, as
// the camera's calibrated delay has it; where drawing takes longer, it comes when it is done. A shot that
// finds the thread busy replaces the one that waits. It is drawn as late as it can be: a real camera takes none of this
// machine's time, so this one leaves the cores to who draws the image before. `start`: when the world's time was 0.
class CameraRenderThread {
 public:
  CameraRenderThread(drivers::laboratory::LabServer& server, const config::WorldFile& world,
                     std::function<RenderView()> make_renderer, Instant<TrueTime> start,
                     ExposureLog* exposures, TraceLog* trace)
      : server_(server),
        make_renderer_(std::move(make_renderer)),
        start_(start),
        latency_(seconds(world.camera.latency_s)),
        exposed_(seconds(0.5 * (world.camera.exposure_s + world.camera.readout_s)) + kTick),
        display_(world),
        faults_(world),
        exposures_(exposures),
        trace_(trace),
        thread_([this] { run(); }) {}
  ~CameraRenderThread() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    wake_.notify_one();
    thread_.join();
  }
  // What the cameras took together; one of them may have lost its frame.
  struct Shots {
    std::optional<CameraShot> left, right;
  };
  void draw(Shots shots) {
    {
      const std::lock_guard lock(mutex_);
      next_ = std::move(shots);
    }
    wake_.notify_one();
  }
  std::uint64_t images() const { return images_; }
  // Why drawing ended early, empty while all is well.
  std::string fault() const {
    const std::lock_guard lock(mutex_);
    return fault_;
  }

 private:
  void run() {
    try {
      const auto render = make_renderer_();
      while (true) {
        Shots shots;
        {
          std::unique_lock lock(mutex_);
          wake_.wait(lock, [this] { return done_ || next_.has_value(); });
          if (done_) return;
          shots = std::move(*next_);
          next_.reset();
        }
        const auto& first = shots.left ? *shots.left : *shots.right;
        const auto drawn_from = begin_drawing(monotonic(first.arrival));
        std::array<device::CameraImage, 2> images;
        for (const auto& [shot, image] :
             {std::pair{&shots.left, &images[0]}, std::pair{&shots.right, &images[1]}})
          if (*shot) *image = draw_shot(**shot, render);
        const auto drawn = arriving_.now();
        if (trace_ != nullptr) trace_->add("camera's image drawn", drawn_from.ns(), drawn.ns(), first.frame);
        const auto taken = first.arrival - latency_;
        // What the display shows until the exposure's end has to be known.
        arriving_.sleep_until(std::min(monotonic(taken + exposed_), monotonic(first.arrival)));
        for (const auto& timecode : server_.take_timecodes())
          display_.show(Instant<TrueTime>{Duration(timecode.sent_ns) - start_.since_epoch}, timecode.code);
        const auto middle = [](const CameraShot& shot) -> const TrueView& {
          return shot.views[shot.views.size() / 2];
        };
        for (const auto& [shot, image] :
             {std::pair{&shots.left, &images[0]}, std::pair{&shots.right, &images[1]}})
          if (*shot) display_.paint(*image, middle(**shot), taken);
        drew(monotonic(first.arrival) - arriving_.now());
        arriving_.sleep_until(monotonic(first.arrival));
        const auto handed = arriving_.now();
        const double since = to_seconds(handed - start_);
        // A camera's images would have come in time, however long drawing has taken here.
        for (auto& image : images) image.waited = handed - monotonic(first.arrival);
        // The right one first: who has the left one then need not wait.
        if (shots.right) publish(std::move(images[1]), 1, since);
        if (!shots.left) continue;
        if (!publish(std::move(images[0]), 0, since)) continue;
        if (exposures_ != nullptr)
          exposures_->add(shots.left->frame, monotonic(taken).ns(), middle(*shots.left),
                          shots.left->mid_exposure);
        ++images_;
      }
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex_);
      fault_ = error.what();
    }
  }

  // Waits until there is just time enough to draw before `arrival`; then it is now.
  Instant<TrueTime> begin_drawing(Instant<TrueTime> arrival) {
    arriving_.sleep_until(arrival - ahead_);
    return arriving_.now();
  }
  // Later from picture to picture until about one in eighty is not done in time: a late one makes two intervals wrong.
  void drew(Duration in_hand) {
    constexpr Duration kLater = std::chrono::microseconds(50), kMuch = std::chrono::milliseconds(4);
    if (in_hand < Duration(0))
      ahead_ = std::min(latency_, ahead_ + 80 * kLater);
    else
      ahead_ = std::max(kLater, ahead_ - (in_hand > kMuch ? (in_hand - kMuch) / 4 : kLater));
  }

  // False where it does not come, by a fault or for another reason.
  bool publish(device::CameraImage image, int camera, double since) {
    std::optional<device::CameraImage> shown = std::move(image);
    faults_.disturb(since, shown);
    return shown && server_.publish_image(*shown, camera);
  }

  Instant<TrueTime> monotonic(Instant<TrueTime> t) const { return start_ + t.since_epoch; }

  drivers::laboratory::LabServer& server_;
  std::function<RenderView()> make_renderer_;
  Instant<TrueTime> start_;
  Duration latency_, exposed_;
  SimulatedDisplay display_;
  DeviceFaults faults_;
  ExposureLog* exposures_;
  TraceLog* trace_;
  MonotonicClock<TrueTime> arriving_;
  Duration ahead_ = latency_;  // of a picture's arrival, where drawing it begins
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Shots> next_;
  bool done_ = false;
  std::string fault_;
  std::atomic<std::uint64_t> images_{0};
  std::thread thread_;
};

// The force on the simulated arm: what whoever commands it wants, as long as it wants it.
class ForceOnArm {
 public:
  void take(drivers::laboratory::LabServer& server, device::ArmDevice& arm) {
    const auto force = server.take_force();
    if (!force) return;
    if (force->let_go || force->age > device::kLongestHold)  // also where this laboratory stood still itself
      arm.command(Vector3::Zero());
    else if (force->count != last_)
      arm.command(force->force);
    last_ = force->count;
  }
  // Says when its commander goes silent, and when one commands again: the same, or another.
  void look_at_commander(drivers::laboratory::LabServer& server) {
    const auto peers = server.peers();
    if (peers.arm_lost && !lost_)
      kLog.warning(
          "whoever commands the arm is silent; the arm is without force until it goes on, or another "
          "`palpate physics` takes it");
    if (peers.arm && lost_) kLog.info("the arm is commanded again");
    lost_ = peers.arm_lost || (lost_ && !peers.arm);
  }

 private:
  std::uint64_t last_ = 0;
  bool lost_ = false;
};

// The devices' faults that the world file asks for, said as they begin and end.
class FaultNews {
 public:
  void look(const DeviceFaults& faults, double since, Instant<TrueTime> now) {
    for (const auto& [code, holds] : faults.at(since))
      if (holds != monitor_.holds(code))
        monitor_.set(holds,
                     {code, fmt::format("fault {} begins", device::name_of(code)),
                      fmt::format("fault {} is over", device::name_of(code))},
                     now);
  }

 private:
  device::HealthMonitor<TrueTime> monitor_{kLog};
};

// Without pictures there still is an arm to feel with: said once.
void look_at_pictures(const CameraRenderThread& render_thread, WorldProcessReport& report) {
  if (!report.picture_fault.empty() || report.ticks % 100 != 0) return;
  report.picture_fault = render_thread.fault();
  if (!report.picture_fault.empty())
    kLog.warning("the camera's picture cannot be drawn: {}; arm and tracker go on without pictures",
                 report.picture_fault);
}

void count_tick(Duration late, WorldProcessReport& report) {
  const double late_s = to_seconds(late);
  ++report.ticks;
  if (late_s > 1e-3) ++report.late_ticks;
  report.worst_late_s = std::max(report.worst_late_s, late_s);
}

drivers::laboratory::LabSettings laboratory_of(const config::WorldFile& file,
                                               const WorldProcessOptions& options) {
  drivers::laboratory::LabSettings settings;
  settings.width = file.camera.size[0];
  settings.height = file.camera.size[1];
  settings.cameras = file.camera.count;
  settings.states_place = file.states_place();
  settings.folder = options.folder;
  return settings;
}

}  // namespace

Expected<WorldProcessReport> run_world(const config::WorldFile& file, const WorldProcessOptions& options,
                                       const std::atomic<bool>& stop) {
  auto opened = drivers::laboratory::LabServer::open(options.name, laboratory_of(file, options));
  if (!opened) return tl::unexpected(opened.error());
  drivers::laboratory::LabServer& server = **opened;
  Simulator world(file, options.seed);
  std::optional<GestureLines> gestures;
  if (options.gestures)
    gestures.emplace(STDIN_FILENO, stdout);
  else
    world.begin_play();
  WorldProcessReport report;
  const MonotonicClock<TrueTime> clock(0.0, 0.0);
  const auto start = clock.now();
  std::optional<ExposureLog> exposures;
  if (!options.exposures.empty()) {
    auto begun = ExposureLog::begin(options.exposures);
    if (!begun) return tl::unexpected(begun.error());
    exposures.emplace(std::move(*begun));
  }
  TraceLog trace("world");
  std::optional<CameraRenderThread> render_thread;
  if (options.make_renderer)
    render_thread.emplace(server, file, options.make_renderer, start, exposures ? &*exposures : nullptr,
                          options.trace.empty() ? nullptr : &trace);
  const auto end =
      options.seconds > 0.0 ? start + seconds(options.seconds) : Instant<TrueTime>{Duration::max()};
  ask_for_short_turns();  // after the thread that draws was started: the world does not wait for its pictures
  auto tick = start;
  ForceOnArm force;
  const DeviceFaults faults(file);
  FaultNews fault_news;
  MonotonicClock<TrueTime> waiting;
  while (!stop.load(std::memory_order_relaxed) && tick < end) {
    tick += kTick;
    waiting.sleep_until(tick);
    const auto now = waiting.now();
    count_tick(now - tick, report);
    if (now > tick + std::chrono::milliseconds(100))
      tick = now;  // after a pause of the machine: go on from here

    force.take(server, world.arm());
    if (const auto target = server.take_hand_target()) {
      world.begin_play();
      world.hand().move_to(*target);
    }
    if (gestures) gestures->look(world.person());
    world.advance_to(Instant<TrueTime>{} + (now - start));
    device::ArmSample arm = world.arm().read();
    arm.waited = waiting.now() - now;
    server.publish_arm(arm);
    const double since = to_seconds(now - start);
    fault_news.look(faults, since, now);
    auto samples = world.tracker().poll();
    faults.disturb(since, samples);
    for (auto& sample : samples) {
      sample.waited += waiting.now() - now;
      server.publish_tracker(sample);
    }
    CameraRenderThread::Shots shots{world.take_shot(), world.take_right_shot()};
    if ((shots.left || shots.right) && render_thread) render_thread->draw(std::move(shots));
    server.heartbeat();
    if (report.ticks == 1 && options.ready) options.ready();
    if (report.ticks == 1) kLog.info("the devices of laboratory '{}' are open", options.name);
    force.look_at_commander(server);
    if (render_thread) look_at_pictures(*render_thread, report);
  }
  if (render_thread) report.images = render_thread->images();
  render_thread.reset();  // it writes the exposures
  if (exposures)
    if (auto done = exposures->finish(); !done) return tl::unexpected(done.error());
  if (!options.trace.empty())
    if (auto done = write_file(options.trace, trace.json()); !done) return tl::unexpected(done.error());
  return report;
}

}  // namespace palpate::sim
