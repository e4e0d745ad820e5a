// Messages of a recorded session, as they stand in recordings of others and in damaged ones: the first byte says of which kind
// the rest is. What is accepted makes sense, and is written as it was read.
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/frame_messages.h"
#include "palpate/record/session/tick_messages.h"

#include <fmt/format.h>

#include "fuzz/check.h"

namespace palpate::fuzz {
namespace {

using namespace record::session;

constexpr std::size_t kMostPixels = 1024 * 1024;  // so that one execution stays short

// Read, written and read again: the same bytes both times. Bytes, since what is no number equals nothing.
template <typename Decode, typename Encode>
void comes_back(std::string_view bytes, Decode decode, Encode encode_it, Refusals& refusals) {
  const auto read = decode(bytes);
  if (!answered(read, refusals)) {
    refusals.back() =
        fmt::format("session.mcap: {}; palpate recording check", refusals.back());  // as its readers say it
    return;
  }
  const std::string written = encode_it(*read);
  const auto again = decode(written);
  hold(again && encode_it(*again) == written, "a message that was read is written as it was");
}

void tracker_sample(std::string_view bytes, Refusals& refusals) {
  comes_back(
      bytes, decode_tracker_sample, [](const RecordedTrackerSample& read) { return encode(read); }, refusals);
  if (const auto read = decode_tracker_sample(bytes); read && read->sample.seen) {
    hold(std::abs(read->sample.rotation.norm() - 1.0) < 1e-6, "a marker that is seen is turned");
    hold_finite(read->sample.translation, "a marker that is seen is somewhere");
    hold_finite(read->sample.covariance, "a marker's covariance is finite");
  }
}

void frame(std::string_view bytes, Refusals& refusals) {
  comes_back(
      bytes, decode_frame, [](const RecordedFrame& read) { return encode(read); }, refusals);
  if (const auto read = decode_frame(bytes); read && read->pose_source != RecordedFrame::PoseSource::none)
    hold_finite(read->X_world_camera, "where the camera was is a pose");
}

void force(std::string_view bytes, Refusals& refusals) {
  const auto decode = [](std::string_view of) -> Expected<haptics::HapticTick> {
    haptics::HapticTick tick;
    if (const auto done = decode_force(of, tick); !done) return tl::unexpected(done.error());
    return tick;
  };
  comes_back(bytes, decode, encode_force, refusals);
}

// Of a size that another message says.
void picture(std::string_view bytes, std::string_view type) {
  if (bytes.size() < 2) return;
  device::CameraImage image;
  image.width = static_cast<unsigned char>(bytes[0]);
  image.height = static_cast<unsigned char>(bytes[1]);
  const auto no_jpeg = [](std::string_view, device::CameraImage&) { return false; };
  if (!decode_picture(bytes.substr(2), type, no_jpeg, image)) return;
  hold(image.rgb.size() ==
               3u * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) &&
           image.rgb.size() <= 3 * kMostPixels,
       "a picture is of the size that was said");
}

}  // namespace

Refusals session_messages(std::string_view file) {
  Refusals refusals;
  if (file.empty()) return refusals;
  const std::string_view bytes = file.substr(1);
  switch (file.front()) {
    case 'a':
      comes_back(bytes, decode_sample, encode_sample, refusals);
      break;
    case 'c':
      comes_back(
          bytes, decode_camera_stamp, [](const RecordedCameraStamp& read) { return encode(read); }, refusals);
      break;
    case 'f':
      frame(bytes, refusals);
      break;
    case 'n':
      force(bytes, refusals);
      break;
    case 'p':
      picture(bytes, "foxglove.RawImage");
      break;
    case 's':
      comes_back(bytes, decode_step, encode_step, refusals);
      break;
    case 't':
      tracker_sample(bytes, refusals);
      break;
    default:
      break;
  }
  return refusals;
}

}  // namespace palpate::fuzz
