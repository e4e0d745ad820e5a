#include "palpate/sim/device_faults.h"

#include <cmath>
#include <utility>

namespace palpate::sim {
namespace {

// Every second pixel of every second row.
void halve(device::CameraImage& image) {
  const int width = image.width / 2, height = image.height / 2;
  if (!image.rgb.empty()) {
    const auto full = static_cast<std::size_t>(image.width);
    std::vector<std::uint8_t> half;
    half.reserve(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t v = 0; v < static_cast<std::size_t>(height); ++v)
      for (std::size_t u = 0; u < static_cast<std::size_t>(width); ++u) {
        const auto* pixel = image.rgb.data() + 3 * (2 * v * full + 2 * u);
        half.insert(half.end(), pixel, pixel + 3);
      }
    image.rgb = std::move(half);
  }
  image.width = width, image.height = height;
}

}  // namespace

bool DeviceFaults::holds(const config::Range& span, double t) const {
  if (faults_.repeat_s > 0.0 && t > 0.0) t = std::fmod(t, faults_.repeat_s);
  return t >= span[0] && t < span[1];
}

void DeviceFaults::disturb(double t, std::optional<device::CameraImage>& image) const {
  if (!image) return;
  if (holds(faults_.camera_clock, t)) image->mid_exposure += seconds(faults_.clock_jump_s);
  if (holds(faults_.image_size, t)) halve(*image);
  if (holds(faults_.camera_silent, t)) image.reset();
}

void DeviceFaults::disturb(double t, std::vector<device::TrackerSample>& samples) const {
  if (holds(faults_.tracker_silent, t)) samples.clear();
  for (auto& sample : samples) {
    if (holds(faults_.tracker_clock, t)) sample.stamp += seconds(faults_.clock_jump_s);
    if (holds(faults_.tracker_blind, t) && sample.marker == device::MarkerId::camera_marker)
      sample.seen = false;
  }
}

std::vector<std::pair<device::HealthCode, bool>> DeviceFaults::at(double t) const {
  using enum device::HealthCode;
  std::vector<std::pair<device::HealthCode, bool>> all;
  for (const auto& [code, span] : {std::pair{camera_silent, &faults_.camera_silent},
                                   {image_size, &faults_.image_size},
                                   {camera_clock, &faults_.camera_clock},
                                   {tracker_silent, &faults_.tracker_silent},
                                   {tracker_blind, &faults_.tracker_blind},
                                   {tracker_clock, &faults_.tracker_clock}})
    all.emplace_back(code, holds(*span, t));
  return all;
}

}  // namespace palpate::sim
