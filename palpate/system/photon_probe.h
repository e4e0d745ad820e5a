// Photon-to-photon delay of a running graphics server: shows the clock strip, reads it in each image, and
// keeps the figures (palpate/graphics_server/photon_meter.h says what is measured).
//
// The strip stands on the simulated laboratory's display, where a thread of its own (`palpate-strip`, 1 kHz)
// shows it, as a frame loop that draws shows nothing new meanwhile; or in the window, which the frame loop
// draws. All else: one thread, the frame loop's. A delay that the strip leaves more than a millisecond unsure
// is counted, and left out of rows and figures.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "palpate/core/csv_file.h"
#include "palpate/core/json.h"
#include "palpate/devices/lab_channel.h"
#include "palpate/graphics_server/graphics_server.h"
#include "palpate/graphics_server/photon_meter.h"
#include "palpate/time/clock.h"

namespace palpate {

class PhotonProbe {
 public:
  // `lab`: the laboratory whose display shows the strip; none: somebody else shows it and says so. `out`:
  // folder for realtime_photons.csv; empty: none. `say`: a line for the log.
  static Expected<std::unique_ptr<PhotonProbe>> open(const std::shared_ptr<LabClient>& lab,
                                                     const PhotonSettings& settings,
                                                     const MonotonicClock<GraphicsClock>& clock,
                                                     const std::filesystem::path& out,
                                                     std::function<void(const std::string&)> say);

  ~PhotonProbe();
  // Somebody else has just shown the strip of this time.
  void shown(Duration code) { meter_.strip_shown(clock_.now(), code); }
  // A frame's picture was handed to the display at `presented`; now there is time to look at its image.
  void look(const GraphicsServer& server, const FrameRecord& frame, Instant<GraphicsClock> presented);

  Json figures() const;
  Expected<void> finish() { return rows_ ? rows_->finish() : Expected<void>(); }

 private:
  PhotonProbe(const PhotonSettings& settings, const MonotonicClock<GraphicsClock>& clock,
              std::function<void(const std::string&)> say)
      : meter_(settings), clock_(clock), say_(std::move(say)) {}

  PhotonMeter meter_;
  const MonotonicClock<GraphicsClock>& clock_;
  std::function<void(const std::string&)> say_;
  void show_time();

  std::unique_ptr<LabDisplay> display_;
  std::mutex mutex_;                                                // held for moments
  std::vector<std::pair<Instant<GraphicsClock>, Duration>> shown_;  // since the last look
  std::atomic<bool> done_{false};
  std::thread thread_;
  std::optional<CsvFile> rows_;
  std::vector<PhotonDelay> delays_;
  std::uint64_t unsure_ = 0;
  bool told_ = false;
};

// From realtime_photons.csv and what `palpate world run --exposures` wrote: how far the measured delays are
// from the true ones. Adds columns true_ms and error_ms to the first file. `scan_out`: the display's own.
Expected<Json> judge_photons(const std::filesystem::path& photons, const std::filesystem::path& exposures,
                             Duration scan_out);

}  // namespace palpate
