// The raw streams of a recording, all at once: what its arm, its tracker and one of its cameras gave, as DeviceStreams, whose host
// time is here seconds after the recording's first message. The moment of arrival is that of the message in the recording.
//
// Ordinary threads. Errors: wrong use for a file that is no recording. A stream that is not there is none: the counts say so.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "palpate/device/device_streams.h"
#include "palpate/record/session/recorded_tables.h"
#include "palpate/record/session/recording_driver.h"

namespace palpate::record::session {

struct StreamsToRead {
  TimeSpan span;        // of these times; the clocks are learned from all there is
  std::string camera;   // "left" or "right"; empty: no camera
  DecodeJpeg decode{};  // empty: only pictures that were recorded lossless can be seen
  // Each picture of the span with its pixels, in the order of the file.
  std::function<void(const device::CameraImage&)> picture{};
};

struct RecordedStreams {
  device::DeviceStreams streams;
  double seconds = 0.0;  // from the first to the last message of the span
  // Within the span.
  std::uint64_t arm = 0, tracker = 0, images = 0, pictures = 0;
  std::uint64_t unread = 0;  // messages that are none, pictures that cannot be decoded
};

Expected<RecordedStreams> read_streams(const std::filesystem::path& recording, const StreamsToRead& what);

}  // namespace palpate::record::session
