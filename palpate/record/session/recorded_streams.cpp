#include "palpate/record/session/recorded_streams.h"

#include <algorithm>
#include <map>
#include <optional>

#include "palpate/record/byte_source.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/recording_copy.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/tick_messages.h"

namespace palpate::record::session {
namespace {

// Images whose picture has not come yet; pictures are packed by a thread of their own, and two wait at most.
constexpr std::size_t kMostWaiting = 64;

class StreamReader : public ScanHandler {
 public:
  StreamReader(const StreamsToRead& what, RecordedStreams& found) : what_(what), found_(found) {
    if (what.camera.empty()) return;
    stamp_topic_ = "/camera/" + what.camera + "/stamp";
    image_topic_ = "/camera/" + what.camera + "/image";
  }

  Expected<void> message(const HeardMessage& heard) override {
    const std::uint64_t now = heard.message.log_time_ns;
    if (!begun_) begun_ = now;
    const bool within = now >= later(*begun_, what_.span.from_s) && now <= later(*begun_, what_.span.to_s);
    if (within) last_ = std::max(last_.value_or(now), now), first_ = std::min(first_.value_or(now), now);
    if (first_ && last_) found_.seconds = 1e-9 * static_cast<double>(*last_ - *first_);
    const std::string type = heard.schema == nullptr ? "" : heard.schema->name;
    const auto arrived = arrival(now);
    if (type == "palpate.recording.ArmSample")
      arm(heard.message.data, arrived, within);
    else if (type == "palpate.recording.TrackerSample")
      tracker(heard.message.data, arrived, within);
    else if (!stamp_topic_.empty() && heard.channel.topic == stamp_topic_)
      stamp(heard.message.data, now, within);
    else if (!image_topic_.empty() && heard.channel.topic == image_topic_)
      picture(heard.message.data, type, now);
    return {};
  }

 private:
  // Small numbers, for they are written with twelve digits.
  Instant<PhysicsClock> arrival(std::uint64_t log_time_ns) const {
    return {Duration(static_cast<std::int64_t>(log_time_ns - *begun_))};
  }

  void arm(std::string_view data, Instant<PhysicsClock> arrived, bool within) {
    const auto decoded = decode_sample(data);
    if (!decoded) {
      ++found_.unread;
      return;
    }
    const auto& sample = decoded->tick.sample;
    if (!sample.connected) return;  // it says what it said last
    found_.streams.add(sample, arrived - sample.waited, Duration(0), within);
    found_.arm += within ? 1 : 0;
  }

  void tracker(std::string_view data, Instant<PhysicsClock> arrived, bool within) {
    const auto decoded = decode_tracker_sample(data);
    if (!decoded) {
      ++found_.unread;
      return;
    }
    found_.streams.add(decoded->sample, arrived, Duration(0), within);
    found_.tracker += within ? 1 : 0;
  }

  void stamp(std::string_view data, std::uint64_t now, bool within) {
    const auto decoded = decode_camera_stamp(data);
    if (!decoded) {
      ++found_.unread;
      return;
    }
    found_.streams.add_image(decoded->image.mid_exposure, arrival(now));
    if (!within) return;
    ++found_.images;
    waiting_[now] = decoded->image;
    if (waiting_.size() > kMostWaiting) waiting_.erase(waiting_.begin());
  }

  // A picture has the log time of its image's stamp; one whose stamp was lost belongs to none.
  void picture(std::string_view data, const std::string& type, std::uint64_t now) {
    const auto at = waiting_.find(now);
    if (at == waiting_.end()) return;
    device::CameraImage image = at->second;
    waiting_.erase(at);
    ++found_.pictures;
    if (!what_.picture) return;
    if (!decode_picture(data, type, what_.decode, image)) {
      ++found_.unread;
      --found_.pictures;
      return;
    }
    what_.picture(image);
  }

  const StreamsToRead& what_;
  RecordedStreams& found_;
  std::string stamp_topic_, image_topic_;
  std::optional<std::uint64_t> begun_, first_, last_;
  std::map<std::uint64_t, device::CameraImage> waiting_;  // by log time
};

}  // namespace

Expected<RecordedStreams> read_streams(const std::filesystem::path& recording, const StreamsToRead& what) {
  auto source = open_source(recording);
  if (!source) return tl::unexpected(source.error());
  RecordedStreams found;
  StreamReader reader(what, found);
  if (const auto scanned = scan(**source, {}, reader); !scanned) return tl::unexpected(scanned.error());
  return found;
}

}  // namespace palpate::record::session
