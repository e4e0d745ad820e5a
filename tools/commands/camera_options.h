// The options by which a real camera is set, the same wherever one is opened.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "palpate/core/text.h"
#include "palpate/device/driver_registry.h"

namespace palpate::tools::commands {

struct CameraOptions {
  double exposure_ms = 0.0, gain = 0.0, rate_hz = 0.0, readout_ms = 0.0;
  std::string format, stamp;
  bool rolling = false, loop = false;
  CLI::Option *has_exposure = nullptr, *has_gain = nullptr;
};

inline void add_camera_options(CLI::App& command, CameraOptions& options) {
  options.has_exposure =
      command.add_option("--camera-exposure-ms", options.exposure_ms,
                         "Set a real camera's exposure by hand; its automatic is switched off");
  options.has_gain =
      command.add_option("--camera-gain", options.gain, "... its gain, in its own unit (GenICam: dB)");
  command.add_option("--camera-rate-hz", options.rate_hz, "... its rate; 0 = its own")->default_val(0.0);
  command.add_option(
      "--camera-format", options.format,
      "... its pixel format: RGB8, BGR8, Mono8, BayerRG8 (GR, GB, BG), YUYV, UYVY, MJPEG; the best where "
      "none is said");
  command.add_option(
      "--camera-stamp", options.stamp,
      "What its stamps mark, where its data sheet knows better: exposure-start, exposure-end or "
      "frame-end");
  command.add_option("--camera-readout-ms", options.readout_ms, "Time in which its rows are read out")
      ->default_val(0.0);
  command.add_flag("--camera-rolling", options.rolling, "It has a rolling shutter");
  command.add_flag("--camera-loop", options.loop, "images: and video: begin again at their end");
}

// Wrong use: a text that names no real camera, settings out of range.
inline Expected<device::CameraRequest> camera_request(const device::DriverRegistry& drivers,
                                                      const std::string& text, const CameraOptions& options) {
  if (!drivers.names_camera(text, device::Offer::real))
    return wrong_use("camera: is '{}'; {} is expected", excerpt(text, 100),
                     drivers.camera_forms(device::Offer::real));
  device::CameraRequest request{text, {}};
  auto& settings = request.settings;
  if (options.has_exposure->count() > 0) settings.exposure_s = options.exposure_ms * 1e-3;
  if (options.has_gain->count() > 0) settings.gain = options.gain;
  settings.rate_hz = options.rate_hz;
  settings.readout_s = options.readout_ms * 1e-3;
  settings.rolling = options.rolling;
  settings.loop = options.loop;
  settings.pixel_format = options.format;
  if (options.stamp == "exposure-start")
    settings.stamp_at = device::StampAt::exposure_start;
  else if (options.stamp == "exposure-end")
    settings.stamp_at = device::StampAt::exposure_end;
  else if (options.stamp == "frame-end")
    settings.stamp_at = device::StampAt::frame_end;
  else if (!options.stamp.empty())
    return wrong_use("--camera-stamp: is '{}'; exposure-start, exposure-end or frame-end is expected",
                     options.stamp);
  if (auto fine = drivers.check(request); !fine) return tl::unexpected(fine.error());
  return request;
}

// Of any kind: a real one as the options say. `drivers`: all there are, which check the request; `known`: those that open it.
inline Expected<std::unique_ptr<device::OpenedCamera>> open_camera(const device::DriverRegistry& drivers,
                                                                   const device::DriverRegistry& known,
                                                                   const std::string& text,
                                                                   const CameraOptions& options) {
  if (!drivers.names_camera(text, device::Offer::real)) return known.open(device::CameraRequest{text, {}});
  const auto request = camera_request(drivers, text, options);
  if (!request) return tl::unexpected(request.error());
  return known.open(*request);
}

}  // namespace palpate::tools::commands
