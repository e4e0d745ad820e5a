// What a running graphics server keeps of its frames: figures for its end and for `palpate status`, rows for
// its log files. One thread, the frame loop's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "palpate/core/csv_file.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/server/graphics/pose_log.h"
#include "palpate/server/graphics/prediction_figures.h"
#include "palpate/time/jitter_histogram.h"
#include "palpate/transport/status.h"

namespace palpate::server::graphics {

// Quantiles of durations in bounded memory: exact for a run of minutes, to 1/16 of the value from then on.
class Quantiles {
 public:
  Quantiles() { first_.reserve(kExact); }
  void add(Duration d);
  double us(double share) const;
  const JitterHistogram& histogram() const { return all_; }

 private:
  static constexpr std::size_t kExact = 4096;
  std::vector<double> first_;
  JitterHistogram all_;
};

// For the end of a run.
Json exchange_json(const Quantiles& trips, std::uint64_t frames, std::uint64_t late,
                   const transport::ExchangeCounters& counters);

// For `palpate status`.
transport::ClientFigures figures_of(std::uint64_t frames, std::uint64_t late, std::uint64_t lost,
                                    double elapsed_s, const JitterHistogram& trips,
                                    const GraphicsServer& server, Instant<GraphicsClock> now);

// realtime_frames.csv, realtime_sync.csv, realtime_poses.csv and, where pictures are predicted,
// realtime_predictions.csv, written as they go: a server may run for days.
struct GraphicsLogs {
  CsvFile frames, sync;
  PoseLog poses;
  std::optional<PredictionLog> predictions;

  static Expected<GraphicsLogs> begin(const std::filesystem::path& folder, PictureTime picture_time,
                                      const scene::SceneDescription& scene);
  struct FrameTimes {
    double shown_s = 0.0;       // since the start
    Duration busy{0}, held{0};  // from its image being taken up until it was ready, and on until it was shown
  };
  // `trip_us` 0: no reply came with it.
  void frame(const FrameRecord& frame, const FrameTimes& times, double trip_us,
             const transport::ExchangeCounters& so_far);
  void clocks(double t, double error_us, Duration stated, Duration offset);
  Expected<void> finish();
};

}  // namespace palpate::server::graphics
