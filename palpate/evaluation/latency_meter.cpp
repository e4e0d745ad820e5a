#include "palpate/evaluation/latency_meter.h"

#include <algorithm>
#include <cmath>

namespace palpate::evaluation {
namespace {

constexpr int kRoom = 48;  // px: a head turning at 100 deg/s, seen with 560 px at 20 Hz
constexpr Duration kExposureStep = std::chrono::milliseconds(1),
                   kLongestExposure = std::chrono::milliseconds(40);
constexpr std::size_t kExposuresTried = 15;  // images after which the exposure counts as known

PictureArea area_round(const TimecodeCorners& corners) {
  PictureArea area{1 << 20, 1 << 20, 0, 0};
  for (const auto& c : corners) {
    area.left = std::min(area.left, static_cast<int>(c.x()) - kRoom);
    area.top = std::min(area.top, static_cast<int>(c.y()) - kRoom);
    area.right = std::max(area.right, static_cast<int>(c.x()) + kRoom + 1);
    area.bottom = std::max(area.bottom, static_cast<int>(c.y()) + kRoom + 1);
  }
  return area;
}

}  // namespace

Expected<LatencyMeter::SeenTimecode> LatencyMeter::timecode_of(const device::CameraImage& image) {
  std::vector<TimecodeCorners> found;
  if (last_) found = find_timecodes(image.rgb, image.width, image.height, last_);
  if (found.empty()) found = find_timecodes(image.rgb, image.width, image.height);
  last_.reset();
  if (found.empty())
    return refused(
        "clock strip: not found in the camera's image; point the camera at it so that it is level, whole and "
        "at least a quarter of the image wide");
  last_ = area_round(found.front());
  const auto blocks = device::panel_blocks(image.rgb, image.width, image.height, found.front());
  if (!blocks) return tl::unexpected(blocks.error());
  const auto bits = device::timecode_bits(*blocks);
  if (!bits) return tl::unexpected(bits.error());
  double row = 0.0;
  for (const auto& corner : found.front()) row += 0.25 * corner.y();
  const double share = (row + 0.5) / static_cast<double>(image.height) - 0.5;
  return SeenTimecode{*bits, seconds(to_seconds(settings_.readout) * share)};
}

Expected<TimecodeMoment> LatencyMeter::moment_of(const device::TimecodeBits& bits,
                                                 Instant<GraphicsClock> arrived, Duration& exposure) {
  if (exposure > Duration(0)) return log_.find(bits, exposure, arrived);
  Expected<TimecodeMoment> best = refused("clock strip: no exposure of up to {} ms looks like this",
                                          kLongestExposure / std::chrono::milliseconds(1));
  for (Duration tried = kExposureStep; tried <= kLongestExposure; tried += kExposureStep) {
    const auto moment = log_.find(bits, tried, arrived);
    if (moment && (!best || moment->residual < best->residual)) best = moment, exposure = tried;
  }
  if (!best) return best;
  exposures_.push_back(exposure);
  if (exposures_.size() == kExposuresTried) {
    std::nth_element(exposures_.begin(), exposures_.begin() + kExposuresTried / 2, exposures_.end());
    settings_.exposure = exposures_[kExposuresTried / 2];
  }
  return best;
}

Expected<LatencySample> LatencyMeter::look(const device::CameraImage& image,
                                           const server::graphics::FrameRecord& frame,
                                           Instant<GraphicsClock> presented) {
  ++images_;
  const auto timecode = timecode_of(image);
  Duration exposure = settings_.exposure;
  const auto moment = timecode ? moment_of(timecode->bits, frame.arrived, exposure)
                               : Expected<TimecodeMoment>(tl::unexpected(timecode.error()));
  trouble_ = moment ? std::string() : moment.error().message;
  if (!moment) return tl::unexpected(moment.error());
  ++read_;
  return LatencySample{.camera_frame = frame.camera_frame,
                       .presented = presented,
                       .exposure = exposure / 2,
                       .transfer = frame.arrived - (moment->middle - timecode->after_middle) -
                                   settings_.scan_out - exposure / 2,
                       .wait = frame.begun - frame.arrived,
                       .draw = presented - frame.begun,
                       .scan_out = settings_.scan_out,
                       .unsure = moment->unsure};
}

}  // namespace palpate::evaluation
