#include "palpate/server/physics/internal/recorded_ticks.h"

#include <fmt/format.h>

#include <functional>

#include "palpate/core/text.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/recording_copy.h"
#include "palpate/record/recording_info.h"
#include "palpate/record/session/tick_messages.h"
#include "palpate/transport/messages.h"

namespace palpate::server::physics {
namespace {

class TickCollector : public record::ScanHandler {
 public:
  explicit TickCollector(RecordedTicks& ticks) : ticks_(ticks) {}

  Expected<void> message(const record::HeardMessage& heard) override {
    const std::string& topic = heard.channel.topic;
    if (topic == "/arm/sample") ticks_.samples.add(heard.message.data);
    if (topic == "/arm/force") ticks_.forces.add(heard.message.data);
    if (topic == "/physics/step") ticks_.steps.add(heard.message.data);
    if (topic == "/physics/state") ticks_.states.push_back(digest(heard.message.data));
    return {};
  }
  Expected<void> attachment(const record::Attachment& attachment) override {
    if (attachment.name == "rig.toml") rig_ = attachment.data;
    if (attachment.name == "scene.pb") scene_ = attachment.data;
    return {};
  }
  Expected<void> metadata(const record::Metadata& metadata) override {
    if (metadata.name == kSetupWords) {
      several_ = several_ || setup_;
      setup_ = metadata.values;
    }
    if (metadata.name == record::kCutMetadata) ticks_.cut = true;
    return {};
  }

  // What came apart from messages, read.
  Expected<void> finish(const std::string& file) {
    if (several_)
      return refused("{}: holds sessions of several physics servers; execute the recording of each by itself",
                     file);
    if (!rig_ || !scene_ || !setup_)
      return refused("{}: holds no physics session from its beginning: {} is missing", file,
                     !rig_     ? "the attachment rig.toml"
                     : !scene_ ? "the attachment scene.pb"
                               : kSetupWords);
    auto rig = rig::parse_rig(*rig_, file + ": rig.toml");
    if (!rig) return tl::unexpected(rig.error());
    auto scene = transport::decode_scene(*scene_);
    if (!scene) return refused("{}: scene.pb: {}", file, scene.error().message);
    auto setup = setup_of(*setup_);
    if (!setup) return refused("{}: {}", file, setup.error().message);
    ticks_.rig = std::move(*rig);
    ticks_.scene = std::move(*scene);
    ticks_.setup = std::move(*setup);
    return {};
  }

 private:
  RecordedTicks& ticks_;
  std::optional<std::string> rig_, scene_;
  std::optional<record::Words> setup_;
  bool several_ = false;  // sessions, as of recordings that were merged
};

}  // namespace

std::uint64_t digest(std::string_view bytes) { return std::hash<std::string_view>{}(bytes); }

Expected<RecordedTicks> RecordedTicks::read(const std::filesystem::path& recording) {
  const std::string file = one_line(recording.string());
  auto source = record::open_source(recording);
  if (!source) return tl::unexpected(source.error());
  RecordedTicks ticks;
  TickCollector collector(ticks);
  record::ScanOptions options;
  options.topics = {"/arm/sample", "/arm/force", "/physics/step", "/physics/state"};
  const auto scanned = record::scan(**source, options, collector);
  if (!scanned) return tl::unexpected(scanned.error());
  if (auto done = collector.finish(file); !done) return tl::unexpected(done.error());
  if (!scanned->complete) ticks.lost = "it is not whole" + record::first_fault(*scanned);
  if (ticks.samples.size() == 0) return refused("{}: holds no tick of a haptic loop", file);
  if (const auto first = ticks.tick(0); first && first->tick.number > 1)
    return refused(
        "{}: begins at tick {} of its session{}; only from the first on it can be executed again{}", file,
        first->tick.number, ticks.cut ? ", cut out of a longer recording" : "",
        ticks.cut ? ": use that recording, or palpate recording cut --from 0" : "");
  return ticks;
}

Expected<record::session::RecordedHapticTick> RecordedTicks::tick(std::size_t i) const {
  auto tick = record::session::decode_sample(samples[i]);
  if (!tick) return tick;
  haptics::HapticTick force;
  if (i >= forces.size()) return refused("its force is missing");
  if (auto done = record::session::decode_force(forces[i], force); !done) return tl::unexpected(done.error());
  if (force.number != tick->tick.number)
    return refused("the force of tick {} follows the reading of tick {}", force.number, tick->tick.number);
  force.begun = tick->tick.begun;
  force.sample = std::move(tick->tick.sample);
  tick->tick = std::move(force);
  return tick;
}

Expected<record::session::RecordedStep> RecordedTicks::step(std::size_t i) const {
  return record::session::decode_step(steps[i]);
}

}  // namespace palpate::server::physics
