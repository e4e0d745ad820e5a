#include "palpate/server/session/side_recording.h"

#include <memory>
#include <thread>

#include "palpate/core/log.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/server/session/physics_meeting.h"
#include "palpate/time/clock.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/state_watch.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::server::session {
namespace {

constexpr Log kSideLog("record");

class SideRecording {
 public:
  explicit SideRecording(const SideRecordingOptions& options) : options_(options) {}

  Expected<Json> run() {
    if (auto done = meet_server(); !done) return tl::unexpected(done.error());
    if (auto done = begin(); !done) return tl::unexpected(done.error());
    if (options_.ready) options_.ready();
    const auto start = clock_.now();
    const auto& stop = stop_requested();
    while (!stop.load() && !recording_->ended() &&
           (options_.seconds <= 0.0 || to_seconds(clock_.now() - start) < options_.seconds)) {
      if (auto done = tick(); !done) return tl::unexpected(done.error());
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    return finish();
  }

 private:
  Expected<void> meet_server();
  Expected<void> begin();
  Expected<void> tick();
  Expected<Json> finish();

  const SideRecordingOptions& options_;
  MonotonicClock<GraphicsClock> clock_;
  std::unique_ptr<transport::StateLink> link_;
  std::unique_ptr<transport::StateWatch> watch_;
  std::unique_ptr<record::session::SessionRecording> recording_;
  record::RecordStream* state_ = nullptr;
  std::unique_ptr<device::OpenedTracker> tracker_;
  std::unique_ptr<device::OpenedCamera> camera_;
  Instant<GraphicsClock> looked_;
};

Expected<void> SideRecording::meet_server() {
  auto place = transport::server_place(options_.server);
  if (!place) return tl::unexpected(place.error());
  auto link = transport::connect_states(place->endpoint, clock_, "record", place->identity);
  if (!link) return tl::unexpected(link.error());
  link_ = std::move(*link);
  if (auto met = await_scene(*link_, {"record", place->endpoint.address}, clock_, stop_requested()); !met)
    return tl::unexpected(met.error());
  auto watch = transport::watch_states(place->endpoint, options_.rate_hz, place->identity);
  if (!watch) return tl::unexpected(watch.error());
  watch_ = std::move(*watch);
  return {};
}

Expected<void> SideRecording::begin() {
  auto begun = record::session::SessionRecording::begin(options_.out, {.recorder = "record", .on_error = {}});
  if (!begun) return tl::unexpected(begun.error());
  recording_ = std::move(*begun);
  if (auto done = recording_->attach("scene.pb", "application/x-protobuf; palpate.wire.SceneDescription",
                                     transport::encode(*link_->description()));
      !done)
    return done;
  state_ = &recording_->stream("/physics/state", "palpate.wire.WorldState");
  const auto drivers = record::session::recorded_drivers(options_.drivers, *recording_, options_.pictures);
  if (options_.tracker) {
    auto tracker = drivers.open(*options_.tracker);
    if (!tracker) return tl::unexpected(tracker.error());
    tracker_ = std::move(*tracker);
  }
  if (options_.camera) {
    auto camera = drivers.open(*options_.camera);
    if (!camera) return tl::unexpected(camera.error());
    camera_ = std::move(*camera);
  }
  kSideLog.info("records {} into {}", link_->description()->application, one_line(options_.out.string()));
  return {};
}

Expected<void> SideRecording::tick() {
  const auto now = clock_.now();
  if (const auto reply = watch_->take(); reply && reply->answer.usable()) {
    const auto time = recording_->log_time(clock_.to_monotonic(now));
    state_->write(time, time, transport::encode(reply->answer.state));
  }
  if (const auto why = watch_->refusal())
    return refused("record: the physics server sends no states: {}", excerpt(*why, 200));
  if (tracker_) tracker_->device().poll();
  if (camera_) camera_->device().poll_unseen();
  link_->poll();
  constexpr Duration kLook = std::chrono::milliseconds(50);
  if (now - looked_ < kLook) return {};
  looked_ = now;
  if (tracker_)
    if (auto there = tracker_->look(); !there) return refused("record: {}", there.error().message);
  if (camera_)
    if (auto there = camera_->look(); !there) return refused("record: {}", there.error().message);
  return {};
}

Expected<Json> SideRecording::finish() {
  tracker_.reset();
  camera_.reset();
  auto figures = recording_->finish();
  const auto counters = watch_->counters();
  if (figures)
    (*figures)["states"] = {
        {"taken", counters.taken}, {"skipped", counters.skipped}, {"missed", counters.missed}};
  return figures;
}

}  // namespace

Expected<Json> record_beside(const SideRecordingOptions& options) {
  stop_requested();  // from here on a signal is a request
  return SideRecording(options).run();
}

}  // namespace palpate::server::session
