// The delay from light to light: from the middle of a camera image's exposure until the picture made of it
// leaves the display; measured, with its parts.
//
// The display shows the timecode and the camera sees the display. The timecode in an image says what stood on
// the display at mid-exposure, and so when that was handed to it: `seen`, which is mid-exposure less the
// display's own delay (scan-out). The picture made of the image is handed to the display at `presented` and
// leaves it by the same scan-out later, so that presented - seen is the whole delay whether scan-out and the
// camera's own latency are known or not. With a rolling shutter the timecode's rows have a moment of their
// own, which is taken back to that of the image's middle. Parts: exposure (its second half), transfer (until
// the image was seen to have arrived), wait (until it was taken up), draw (until its picture was handed to
// the display), scan-out. Of transfer and scan-out only the sum is measured; scan-out is as stated. Host time
// of the graphics server. One thread, the frame loop's; some milliseconds for an image, so called once its
// picture is out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpate/device/devices.h"
#include "palpate/evaluation/timecode_finder.h"
#include "palpate/evaluation/timecode_log.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::evaluation {

struct LatencySettings {
  Duration exposure{0};  // 0: not known; it is then found from the first images' greys
  Duration scan_out{0};
  Duration readout{0};  // of a rolling shutter, first to last row; 0: a global one
};

struct LatencySample {  // of one picture
  std::uint64_t camera_frame = 0;
  Instant<GraphicsClock> presented;
  Duration exposure{0}, transfer{0}, wait{0}, draw{0}, scan_out{0};
  Duration unsure{0};  // half of the span of delays that would look the same (timecode_log.h)
  Duration total() const { return exposure + transfer + wait + draw + scan_out; }
};

class LatencyMeter {
 public:
  explicit LatencyMeter(const LatencySettings& settings) : settings_(settings) {}

  // The timecode of time `code` was handed to the display at `at`.
  void timecode_shown(Instant<GraphicsClock> at, Duration code) { log_.show(at, code); }

  // The image of a frame whose picture was handed to the display at `presented`. Refused, with the reason,
  // where no timecode can be read in it.
  Expected<LatencySample> look(const device::CameraImage& image, const server::graphics::FrameRecord& frame,
                               Instant<GraphicsClock> presented);

  std::uint64_t images() const { return images_; }
  std::uint64_t read() const { return read_; }
  // In use; 0 while it is not known.
  Duration exposure() const { return settings_.exposure; }
  // Why the latest image could not be read; empty where it could.
  const std::string& trouble() const { return trouble_; }

 private:
  struct SeenTimecode {
    device::TimecodeBits bits{};
    Duration after_middle{0};  // its rows' exposure, after that of the image's middle
  };
  Expected<SeenTimecode> timecode_of(const device::CameraImage& image);
  Expected<TimecodeMoment> moment_of(const device::TimecodeBits& bits, Instant<GraphicsClock> arrived,
                                     Duration& exposure);

  LatencySettings settings_;
  TimecodeLog log_;
  std::optional<PictureArea> last_;  // where the timecode was, with room for a head that turns
  std::vector<Duration> exposures_;  // as the first images have them
  std::uint64_t images_ = 0, read_ = 0;
  std::string trouble_;
};

}  // namespace palpate::evaluation
