#include "palpate/record/session/recording_driver.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/record/message_feed.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/recorded_arm.h"
#include "palpate/record/session/tick_messages.h"
#include "palpate/time/clock.h"

namespace palpate::record::session {
namespace {

// One stream at the pace at which it came.
class PacedStream {
 public:
  static Expected<std::unique_ptr<PacedStream>> open(const std::string& file, std::vector<std::string> topics,
                                                     const char* what) {
    auto source = open_source(file);
    if (!source) return tl::unexpected(source.error());
    ScanOptions options;
    options.topics = std::move(topics);
    auto stream = std::make_unique<PacedStream>(std::move(*source), std::move(options));
    if (stream->feed_.next() == nullptr) {
      if (!stream->feed_.result()) return tl::unexpected(stream->feed_.result().error());
      return refused("{}: holds nothing of {}", one_line(file), what);
    }
    return stream;
  }
  PacedStream(std::unique_ptr<ByteSource> source, ScanOptions options)
      : feed_(std::move(source), std::move(options)) {}

  // The next one whose time has come; valid until take().
  const MessageFeed::Item* due() {
    const auto* item = feed_.ready();
    if (item == nullptr) return nullptr;
    const std::int64_t now = MonotonicClock<PhysicsClock>::monotonic_ns();
    const auto time = static_cast<std::int64_t>(item->message.log_time_ns);
    if (!begun_) begun_ = now - time;
    return now - *begun_ >= time ? item : nullptr;
  }
  void take() { feed_.take(); }
  bool over() { return feed_.over(); }

 private:
  MessageFeed feed_;
  std::optional<std::int64_t> begun_;  // the machine's clock minus the recording's
};

class ReplayedArm : public device::OpenedArm, public device::ArmDevice {
 public:
  ReplayedArm(std::unique_ptr<PacedStream> stream, std::string file, bool states_place)
      : stream_(std::move(stream)), file_(std::move(file)), states_place_(states_place) {}
  device::ArmDevice& device() override { return *this; }
  device::ArmFacts facts() const override {
    device::ArmFacts facts;
    facts.identity = "recording:" + file_;
    facts.states_place = states_place_;
    return facts;
  }
  std::string description() const override { return "the arm of the recording " + file_; }
  device::ArmSample read() override {
    while (const auto* item = stream_->due()) {
      if (const auto sample = decode_sample(item->data)) sample_ = sample->tick.sample;
      stream_->take();
    }
    if (stream_->over()) sample_.connected = false;
    return sample_;
  }
  void command(const Vector3&) override {}
  void let_go() noexcept override {}

 private:
  std::unique_ptr<PacedStream> stream_;
  std::string file_;
  bool states_place_;
  device::ArmSample sample_;
};

class ReplayedTracker : public device::OpenedTracker, public device::TrackerDevice {
 public:
  explicit ReplayedTracker(std::unique_ptr<PacedStream> stream) : stream_(std::move(stream)) {}
  device::TrackerDevice& device() override { return *this; }
  std::string why_unheard() const override { return ended_ ? "the recording has ended" : ""; }
  std::vector<device::TrackerSample> poll() override {
    std::vector<device::TrackerSample> samples;
    while (const auto* item = stream_->due()) {
      if (auto sample = decode_tracker_sample(item->data)) samples.push_back(sample->sample);
      stream_->take();
    }
    ended_ = stream_->over();
    return samples;
  }

 private:
  std::unique_ptr<PacedStream> stream_;
  bool ended_ = false;
};

// The stamps of its images and, where they were recorded, the images.
class ReplayedCamera : public device::OpenedCamera, public device::CameraDevice {
 public:
  ReplayedCamera(std::unique_ptr<PacedStream> stream, std::string file, DecodeJpeg decode)
      : stream_(std::move(stream)), file_(std::move(file)), decode_(std::move(decode)) {}
  device::CameraDevice& device() override { return *this; }
  std::string name() const override { return "recording:" + file_; }
  std::string description() const override { return "the camera of a recording"; }
  bool ended() const override { return ended_; }
  std::optional<device::HealthReport> health() override {
    if (!ended_) return std::nullopt;
    return device::HealthReport{device::HealthCode::recording_ended,
                                "camera " + name() + ": the recording has ended", ""};
  }
  std::optional<device::CameraImage> poll() override {
    std::optional<device::CameraImage> newest;
    while (const auto* item = stream_->due()) {
      take(*item, newest);
      stream_->take();
    }
    ended_ = stream_->over();
    return newest;
  }

 private:
  // A stamp comes before its picture; a picture whose stamp was lost belongs to none.
  void take(const MessageFeed::Item& item, std::optional<device::CameraImage>& newest) {
    const std::string type = item.schema ? item.schema->name : "";
    if (type == "palpate.recording.CameraStamp") {
      if (const auto stamp = decode_camera_stamp(item.data)) stamp_ = stamp->image;
      return;
    }
    if (!stamp_) return;
    device::CameraImage image = *stamp_;
    stamp_.reset();
    if (decode_picture(item.data, type, decode_, image)) newest = std::move(image);
  }

  std::unique_ptr<PacedStream> stream_;
  std::string file_;
  DecodeJpeg decode_;
  std::optional<device::CameraImage> stamp_;
  bool ended_ = false;
};

struct Place {
  std::string file, stream;
};

// "recording:FILE#STREAM"
Place place_of(std::string_view uri) {
  const std::string rest(device::rest_of(uri));
  const auto hash = rest.rfind('#');
  if (hash == std::string::npos) return {rest, ""};
  return {rest.substr(0, hash), rest.substr(hash + 1)};
}

bool names_file(std::string_view uri) { return !place_of(uri).file.empty(); }

template <typename Opener, typename Open>
Opener opener(const char* form, Open open) {
  Opener made;
  made.form = form;
  made.names = names_file;
  made.open = std::move(open);
  return made;
}

}  // namespace

void add_to(device::DriverRegistry& registry, DecodeJpeg decode) {
  device::Driver driver;
  driver.scheme = "recording";
  driver.summary = "devices of a recorded session, as they were";
  driver.recording = true;
  driver.own_clock = true;
  driver.arm = opener<device::ArmOpener>(
      "recording:FILE",
      [](const device::ArmRequest& request) -> Expected<std::unique_ptr<device::OpenedArm>> {
        const auto place = place_of(request.uri);
        auto stream = PacedStream::open(place.file, {"/arm/sample"}, "an arm");
        if (!stream) return tl::unexpected(stream.error());
        const auto recorded = recorded_arm(place.file).value_or(request.nominal);
        return std::make_unique<ReplayedArm>(std::move(*stream), place.file,
                                             recorded.kind == device::ArmModel::Kind::cartesian);
      });
  driver.tracker = opener<device::TrackerOpener>(
      "recording:FILE",
      [](const device::TrackerRequest& request) -> Expected<std::unique_ptr<device::OpenedTracker>> {
        auto stream = PacedStream::open(place_of(request.uri).file, {"/tracker/sample"}, "a tracker");
        if (!stream) return tl::unexpected(stream.error());
        return std::make_unique<ReplayedTracker>(std::move(*stream));
      });
  driver.camera = opener<device::CameraOpener>(
      "recording:FILE[#right]",
      [decode](const device::CameraRequest& request) -> Expected<std::unique_ptr<device::OpenedCamera>> {
        const auto place = place_of(request.uri);
        const std::string topic = "/camera/" + (place.stream.empty() ? std::string("left") : place.stream);
        auto stream = PacedStream::open(place.file, {topic + "/stamp", topic + "/image"}, "that camera");
        if (!stream) return tl::unexpected(stream.error());
        return std::make_unique<ReplayedCamera>(std::move(*stream), place.file, decode);
      });
  registry.add(std::move(driver));
}

}  // namespace palpate::record::session
