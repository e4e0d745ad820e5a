#include "palpate/sim/simulated_camera.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace palpate::sim {

SimulatedCamera::SimulatedCamera(const config::WorldFile& world, std::uint64_t seed, std::string_view name)
    : interval_s_(1.0 / world.camera.rate_hz),
      latency_(seconds(world.camera.latency_s)),
      drop_(world.camera.drop),
      readout_s_(world.camera.readout_s),
      exposure_s_(world.camera.exposure_s),
      blur_steps_(world.camera.blur_steps),
      rolling_(world.camera.shutter == "rolling"),
      drops_(seed, std::string(name) + "/drops") {
  // Half a readout before the first mid-exposure is still after the world began.
  first_ = next_ = Instant<TrueTime>::from_seconds(0.5 * interval_s_);
}

Duration SimulatedCamera::moment_offset(int moment) const {
  const int band = moment / blur_steps_, step = moment % blur_steps_;
  const double in_exposure = exposure_s_ * ((step + 0.5) / blur_steps_ - 0.5);
  return seconds(in_exposure + (rolling_ ? readout_s_ * ((band + 0.5) / kRollingBands - 0.5) : 0.0));
}

void SimulatedCamera::expose(Instant<CameraClock> stamp, std::vector<TrueView> views) {
  const bool dropped = drops_.chance(drop_);
  if (!dropped && !views.empty()) {
    pending_.push_back({next_ + latency_, stamp, frame_, blur_steps_, std::move(views)});
    // Nobody takes images that are seconds old.
    if (pending_.size() > 64) pending_.pop_front();
  }
  ++frame_;
  next_ = first_ + seconds(static_cast<double>(frame_) * interval_s_);
}

void SimulatedCamera::set_rate(double rate_hz) {
  interval_s_ = 1.0 / rate_hz;
  first_ = next_ - seconds(static_cast<double>(frame_) * interval_s_);
}

std::optional<CameraShot> SimulatedCamera::take(Instant<TrueTime> now) {
  std::optional<CameraShot> newest;
  while (!pending_.empty() && pending_.front().arrival <= now) {
    newest = std::move(pending_.front());
    pending_.pop_front();
  }
  return newest;
}

device::CameraImage draw_shot(const CameraShot& shot, const RenderView& render) {
  device::CameraImage image;
  image.mid_exposure = shot.mid_exposure;
  image.frame = shot.frame;
  image.width = shot.views.front().lens.width;
  image.height = shot.views.front().lens.height;
  if (!render) return image;
  if (shot.views.size() == 1) {
    render(shot.views.front(), image.rgb);
    return image;
  }
  const auto steps = static_cast<std::size_t>(shot.blur_steps), bands = shot.views.size() / steps;
  const auto rows = static_cast<std::size_t>(image.height),
             row_bytes = static_cast<std::size_t>(image.width) * 3;
  image.rgb.resize(rows * row_bytes);
  std::vector<std::uint8_t> picture;
  std::vector<std::uint32_t> light;
  bool blind = false;  // the renderer looks on and draws nothing
  for (std::size_t band = 0; band < bands; ++band) {
    const std::size_t from = rows * band / bands * row_bytes, to = rows * (band + 1) / bands * row_bytes;
    light.assign(to - from, 0);
    for (std::size_t step = 0; step < steps; ++step) {
      render(shot.views[band * steps + step], picture);
      blind = picture.empty();
      if (steps == 1 || blind) continue;
      // Pictures hold square roots of light.
      for (std::size_t i = from; i < to; ++i)
        light[i - from] += static_cast<std::uint32_t>(picture[i]) * picture[i];
    }
    if (blind) continue;
    if (steps == 1) {
      std::copy(picture.begin() + static_cast<std::ptrdiff_t>(from),
                picture.begin() + static_cast<std::ptrdiff_t>(to),
                image.rgb.begin() + static_cast<std::ptrdiff_t>(from));
    } else {
      for (std::size_t i = from; i < to; ++i)
        image.rgb[i] = static_cast<std::uint8_t>(
            std::lround(std::sqrt(static_cast<double>(light[i - from]) / static_cast<double>(steps))));
    }
  }
  if (blind) image.rgb.clear();
  return image;
}

}  // namespace palpate::sim
