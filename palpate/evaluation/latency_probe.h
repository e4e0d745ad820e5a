// Photon-to-photon delay of a running graphics server: shows the timecode, reads it in each image, and
// keeps the figures (palpate/evaluation/latency_meter.h says what is measured).
//
// The timecode stands on the simulated display, where a thread of its own (`palpate-strip`, 1
// kHz) shows it, as a frame loop that draws shows nothing new meanwhile; or in the window, which the frame
// loop draws. All else: one thread, the frame loop's. A delay that the timecode leaves more than a
// millisecond unsure is counted, and left out of rows and figures.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "palpate/core/csv_file.h"
#include "palpate/core/json.h"
#include "palpate/device/opened.h"
#include "palpate/evaluation/latency_meter.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/time/clock.h"

namespace palpate::evaluation {

class LatencyProbe {
 public:
  // `display`: shows the timecode; none: somebody else shows it and says so. `out`: folder for
  // realtime_photons.csv; empty: none.
  static Expected<std::unique_ptr<LatencyProbe>> open(std::unique_ptr<device::OpenedDisplay> display,
                                                      const LatencySettings& settings,
                                                      const MonotonicClock<GraphicsClock>& clock,
                                                      const std::filesystem::path& out);

  ~LatencyProbe();
  // Somebody else has just shown the timecode of this time.
  void shown(Duration code) { meter_.timecode_shown(clock_.now(), code); }
  // A frame's picture was handed to the display at `presented`; now there is time to look at its image.
  void look(const server::graphics::GraphicsServer& server, const server::graphics::FrameRecord& frame,
            Instant<GraphicsClock> presented);

  Json figures() const;
  Expected<void> finish() { return rows_ ? rows_->finish() : Expected<void>(); }

 private:
  LatencyProbe(const LatencySettings& settings, const MonotonicClock<GraphicsClock>& clock)
      : meter_(settings), clock_(clock) {}

  LatencyMeter meter_;
  const MonotonicClock<GraphicsClock>& clock_;
  void show_time();

  std::unique_ptr<device::OpenedDisplay> display_;
  std::mutex mutex_;                                                // held for moments
  std::vector<std::pair<Instant<GraphicsClock>, Duration>> shown_;  // since the last look
  std::atomic<bool> done_{false};
  std::thread thread_;
  std::optional<CsvFile> rows_;
  std::vector<LatencySample> delays_;
  std::uint64_t unsure_ = 0;
  bool told_ = false;
};

// From realtime_photons.csv and what `palpate world run --exposures` wrote: how far the measured delays are
// from the true ones. Adds columns true_ms and error_ms to the first file. `scan_out`: the display's own.
Expected<Json> evaluate_latency(const std::filesystem::path& photons, const std::filesystem::path& exposures,
                                Duration scan_out);

}  // namespace palpate::evaluation
