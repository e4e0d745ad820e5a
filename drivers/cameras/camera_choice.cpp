#include "drivers/cameras/camera_choice.h"

#include <cmath>

#include "drivers/cameras/aravis_source.h"
#include "drivers/cameras/recorded_source.h"
#include "drivers/cameras/v4l2_source.h"
#include "palpate/core/text.h"

namespace palpate::drivers::cameras {

Expected<Choice> parse_choice(std::string_view text) {
  const auto colon = text.find(':');
  const std::string_view kind = text.substr(0, colon);
  std::string which(colon == std::string_view::npos ? "" : text.substr(colon + 1));
  const bool named = !which.empty(), bare = colon == std::string_view::npos;
  if (kind == "aravis" && (bare || named)) return Choice{Kind::aravis, which};
  if (kind == "images" && named) return Choice{Kind::images, which};
  if (kind == "video" && named) return Choice{Kind::video, which};
  if (kind == "v4l2" && (bare || named)) {
    if (named && which.find_first_not_of("0123456789") == std::string::npos) which = "/dev/video" + which;
    return Choice{Kind::v4l2, which};
  }
  return wrong_use("camera: is '{}'; {} is expected", excerpt(text, 100), kChoices);
}

Expected<void> check_settings(const Choice& choice, const CameraSettings& settings) {
  const bool recorded = choice.kind == Kind::images || choice.kind == Kind::video;
  if (settings.loop && !recorded)
    return wrong_use("a camera has no end to begin again at; leave --camera-loop to images: and video:");
  if (recorded && (settings.rate_hz != 0.0 || settings.exposure_s || settings.gain ||
                   !settings.pixel_format.empty() || settings.stamp_at || settings.readout_s != 0.0))
    return wrong_use(
        "a recording has no exposure, gain, rate, format or stamp to set; leave those options out");
  if (settings.exposure_s && !(*settings.exposure_s >= 1e-6 && *settings.exposure_s <= 10.0))
    return wrong_use("exposure {:g} ms: 0.001 to 10000 ms is expected", *settings.exposure_s * 1e3);
  if (settings.gain && !std::isfinite(*settings.gain)) return wrong_use("gain: a finite number is expected");
  if (settings.rate_hz != 0.0 && !(settings.rate_hz >= 1.0 && settings.rate_hz <= 1000.0))
    return wrong_use("rate {:g} Hz: 1 to 1000 Hz is expected", settings.rate_hz);
  if (!(settings.readout_s >= 0.0 && settings.readout_s <= 1.0))
    return wrong_use("readout {:g} ms: 0 to 1000 ms is expected", settings.readout_s * 1e3);
  if (!settings.pixel_format.empty() && !format_named(settings.pixel_format))
    return wrong_use(
        "pixel format '{}': RGB8, BGR8, Mono8, BayerRG8 (GR, GB, BG), YUYV, UYVY or MJPEG is expected",
        excerpt(settings.pixel_format));
  return {};
}

std::unique_ptr<FrameSource> make_source(const Choice& choice, const CameraSettings& settings) {
  switch (choice.kind) {
    case Kind::aravis:
      return make_aravis_source(choice.which, settings);
    case Kind::v4l2:
      return make_v4l2_source(choice.which, settings);
    case Kind::images:
      return make_folder_source(choice.which, settings.loop);
    case Kind::video:
      break;
  }
  return make_video_source(choice.which, settings.loop);
}

Expected<std::unique_ptr<LiveCamera>> open_camera(const CameraRequest& request) {
  if (auto fine = check_settings(request.choice, request.settings); !fine)
    return tl::unexpected(fine.error());
  return LiveCamera::open(make_source(request.choice, request.settings), request.settings.width,
                          request.settings.height);
}

std::string description(const CameraFacts& facts) {
  std::string text = facts.model.empty() ? "camera" : facts.model;
  if (!facts.serial.empty()) text += fmt::format(" (serial {})", facts.serial);
  text += fmt::format(", {}x{} px, {}", facts.width, facts.height, name_of(facts.format));
  if (facts.rate_hz > 0.0) text += fmt::format(", {:.1f} Hz", facts.rate_hz);
  if (facts.exposure_s > 0.0) text += fmt::format(", exposure {:.2f} ms", facts.exposure_s * 1e3);
  return text;
}

}  // namespace palpate::drivers::cameras
