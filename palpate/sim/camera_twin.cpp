#include "palpate/sim/camera_twin.h"

#include <algorithm>

namespace palpate::sim {

CameraTwin::CameraTwin(const WorldFile& world, std::uint64_t seed)
    : interval_s_(1.0 / world.camera.rate_hz),
      latency_(seconds(world.camera.latency_s)),
      drop_(world.camera.drop),
      readout_s_(world.camera.readout_s),
      rolling_(world.camera.shutter == "rolling"),
      drops_(seed, "camera/drops") {
  // Half a readout before the first mid-exposure is still after the world began.
  first_ = next_ = Instant<TrueTime>::from_seconds(0.5 * interval_s_);
}

Duration CameraTwin::band_offset(int band) const {
  if (!rolling_) return Duration(0);
  return seconds(readout_s_ * ((band + 0.5) / kRollingBands - 0.5));
}

void CameraTwin::expose(Instant<CameraClock> stamp, std::vector<TrueView> views) {
  const bool dropped = drops_.chance(drop_);
  if (!dropped && !views.empty()) {
    pending_.push_back({next_ + latency_, {stamp, frame_, std::move(views)}});
    // Nobody takes images that are seconds old.
    if (pending_.size() > 64) pending_.pop_front();
  }
  ++frame_;
  next_ = first_ + seconds(static_cast<double>(frame_) * interval_s_);
}

std::optional<CameraShot> CameraTwin::take(Instant<TrueTime> now) {
  std::optional<CameraShot> newest;
  while (!pending_.empty() && pending_.front().arrival <= now) {
    newest = std::move(pending_.front().shot);
    pending_.pop_front();
  }
  return newest;
}

CameraImage draw_shot(const CameraShot& shot, const RenderView& render) {
  CameraImage image;
  image.mid_exposure = shot.mid_exposure;
  image.frame = shot.frame;
  image.width = shot.views.front().lens.width;
  image.height = shot.views.front().lens.height;
  if (!render) return image;
  render(shot.views.front(), image.rgb);
  const auto rows = static_cast<std::size_t>(image.height),
             row_bytes = static_cast<std::size_t>(image.width) * 3;
  std::vector<std::uint8_t> band_picture;
  for (std::size_t band = 1; band < shot.views.size(); ++band) {
    render(shot.views[band], band_picture);
    const std::size_t from = rows * band / shot.views.size() * row_bytes;
    const std::size_t to = rows * (band + 1) / shot.views.size() * row_bytes;
    std::copy(band_picture.begin() + static_cast<std::ptrdiff_t>(from),
              band_picture.begin() + static_cast<std::ptrdiff_t>(to),
              image.rgb.begin() + static_cast<std::ptrdiff_t>(from));
  }
  return image;
}

}  // namespace palpate::sim
