#include "palpate/server/physics/recording_show.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>

#include "palpate/core/log.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/record/byte_source.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/session/shape_messages.h"
#include "palpate/scene/scene_history.h"
#include "palpate/scene/shape_history.h"
#include "palpate/time/clock.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/zmq_engine.h"

namespace palpate::server::physics {
namespace {

constexpr Log kReplayLog("replay");
constexpr const char *kStates = "/physics/state", *kShapes = "/physics/shape";

// Serves from the moment it knows the scene; each state goes into the history when its time has come.
class Show : public record::ScanHandler {
 public:
  explicit Show(const ShowOptions& options) : options_(options) {}

  Expected<void> attachment(const record::Attachment& attachment) override {
    if (attachment.name != "scene.pb" || service_) return {};
    const auto scene = transport::decode_scene(attachment.data);
    if (!scene) return refused("{}: scene.pb: {}", file(), scene.error().message);
    history_ = std::make_unique<scene::SceneHistory>(scene->gravity);
    shapes_ = std::make_unique<scene::ShapeHistory>(scene->shape_vertices);
    auto service = transport::serve_states(
        options_.place.endpoint, clock_, [this](Instant<PhysicsClock> t) { return history_->at(t); }, *scene,
        {.identity = options_.place.identity,
         .status = [this, begun = clock_.now()]() -> transport::ServerStatus {
           return {.uptime_s = to_seconds(clock_.now() - begun)};
         },
         .shape = [this](Instant<PhysicsClock> t, std::span<float> out) { return shapes_->at(t, out); }});
    if (!service) return tl::unexpected(service.error());
    service_ = std::move(*service);
    kReplayLog.info("shows {} at {}", file(), service_->endpoint());
    if (options_.ready) options_.ready();
    return {};
  }

  Expected<void> message(const record::HeardMessage& heard) override {
    if (!service_)
      return refused("{}: holds no session of a physics server: the attachment scene.pb is missing", file());
    if (heard.channel.topic == kShapes) return take_shape(heard.message.data);
    auto state = transport::decode_state(heard.message.data);
    if (!state) return tl::unexpected(state.error());
    if (!first_) first_ = state->time;
    const double since = to_seconds(state->time - *first_);
    if (since < options_.from_s) return {};
    if (since > options_.to_s) return refused(ErrorCode::no_more, "");
    if (!begun_) begin(since);
    const auto due = begun_->here + seconds((since - begun_->since) / options_.speed);
    clock_.sleep_until(due);
    while (service_->take_control())
      kReplayLog.warning("warning: somebody wishes something; a recording does what it did");
    if (stop_.load()) return refused(ErrorCode::stopped, "");
    state->time = due;
    state->tick = ++states_;
    history_->push(*state);
    show_shape(state->time);
    shown_s_ = since - begun_->since;
    return {};
  }

  // For the next time round: its first state follows the last one.
  void rewind() {
    begun_.reset();
    first_.reset();
    total_s_ += shown_s_;
    shown_s_ = 0.0;
  }

  bool served() const { return service_ != nullptr; }
  std::uint64_t states() const { return states_; }
  Json figures() const {
    return {
        {"seconds", total_s_ + shown_s_}, {"states", states_}, {"requests", service_->counters().requests}};
  }

 private:
  struct Beginning {
    Instant<PhysicsClock> here;
    double since;
  };
  void begin(double since) { begun_ = Beginning{clock_.now(), since}; }
  // What it says of the surface counts from the state that follows on.
  Expected<void> take_shape(std::string_view bytes) {
    const auto taken = shape_.decode(bytes);
    if (!taken) return tl::unexpected(taken.error());
    shape_waits_ = *taken;
    return {};
  }
  void show_shape(Instant<PhysicsClock> now) {
    if (!shape_waits_) return;
    shapes_->push(now, shape_.shape().values);
    shape_waits_ = false;
  }
  std::string file() const { return one_line(options_.recording.string()); }

  const ShowOptions& options_;
  const std::atomic<bool>& stop_ = stop_requested();
  MonotonicClock<PhysicsClock> clock_;
  std::unique_ptr<scene::SceneHistory> history_;
  std::unique_ptr<scene::ShapeHistory> shapes_;
  record::session::ShapeDecoder shape_;
  bool shape_waits_ = false;
  std::unique_ptr<transport::StateService> service_;
  std::optional<Instant<PhysicsClock>> first_;
  std::optional<Beginning> begun_;
  std::uint64_t states_ = 0;
  double shown_s_ = 0.0, total_s_ = 0.0;
};

}  // namespace

Expected<Json> show_recording(const ShowOptions& options) {
  stop_requested();  // from here on a signal is a request
  record::ScanOptions scan_options;
  scan_options.topics = {kStates, kShapes};
  Show show(options);
  for (bool again = true; again;) {
    auto source = record::open_source(options.recording);
    if (!source) return tl::unexpected(source.error());
    const std::uint64_t before = show.states();
    const auto scanned = record::scan(**source, scan_options, show);
    const bool over = !scanned && (scanned.error().code == ErrorCode::no_more ||
                                   scanned.error().code == ErrorCode::stopped);
    if (!scanned && !over) return tl::unexpected(scanned.error());
    if (scanned)
      if (auto fine = record::check_is_recording(*scanned, one_line(options.recording.string())); !fine)
        return tl::unexpected(fine.error());
    if (show.states() == before && !stop_requested().load())
      return refused("{}: holds no state of a world{}", one_line(options.recording.string()),
                     options.from_s > 0.0 ? " from there on" : "");
    again = options.loop && !stop_requested().load();
    if (again) show.rewind();
  }
  return show.figures();
}

}  // namespace palpate::server::physics
