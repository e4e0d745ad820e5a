#include "palpate/server/graphics/graphics_figures.h"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/csv.h"
#include "palpate/core/statistics.h"
#include "palpate/server/graphics/record_names.h"

namespace palpate::server::graphics {

void Quantiles::add(Duration d) {
  if (first_.size() < kExact) first_.push_back(to_seconds(d) * 1e6);
  all_.add(d);
}

double Quantiles::us(double share) const {
  if (all_.count() > kExact) return to_seconds(all_.quantile(share)) * 1e6;
  ErrorSummary summary;
  for (const double v : first_) summary.add(v);
  return summary.quantile(share);
}

transport::ClientFigures figures_of(std::uint64_t frames, std::uint64_t late, std::uint64_t lost,
                                    double elapsed_s, const JitterHistogram& trips,
                                    const GraphicsServer& server, Instant<GraphicsClock> now) {
  transport::ClientFigures figures{.frames = frames,
                                   .late = late,
                                   .lost = lost,
                                   .rate_hz = elapsed_s > 0.0 ? static_cast<double>(frames) / elapsed_s : 0.0,
                                   .round_trip_median_us = 1e6 * to_seconds(trips.quantile(0.5)),
                                   .round_trip_p99_us = 1e6 * to_seconds(trips.quantile(0.99))};
  for (const auto& condition : server.conditions())
    figures.conditions.push_back(
        {condition.code, std::max(0.0, to_seconds(now - condition.since)), condition.words});
  const auto& sync = server.sync();
  if (sync.exchanges() > 0) {
    figures.clock_offset_s = 1e-9 * static_cast<double>(sync.model().to(now).ns() - now.ns());
    figures.clock_uncertainty_us = 1e6 * to_seconds(sync.model().uncertainty(now));
  }
  return figures;
}

Json exchange_json(const Quantiles& trips, std::uint64_t frames, std::uint64_t late,
                   const transport::ExchangeCounters& counters) {
  return {{"round_trip_us", {{"median", trips.us(0.5)}, {"p99", trips.us(0.99)}}},
          {"frames", frames},
          {"late", late},
          {"lost", counters.lost},
          {"unsent", counters.unsent},
          {"repeated", counters.duplicated},
          {"out_of_order", counters.out_of_order}};
}

Expected<GraphicsLogs> GraphicsLogs::begin(const std::filesystem::path& folder, PictureTime picture_time,
                                           const scene::SceneDescription& scene) {
  // From `unsent` on: how many since the start.
  auto frames = CsvFile::begin(folder / "realtime_frames.csv",
                               {"frame", "time_s", "round_trip_us", "late", "answer", "landmarks_used",
                                "busy_us", "held_us", "unsent", "lost", "repeated", "out_of_order"});
  if (!frames) return tl::unexpected(frames.error());
  auto sync = CsvFile::begin(folder / "realtime_sync.csv",
                             {"time_s", "offset_error_us", "uncertainty_us", "offset_s"});
  if (!sync) return tl::unexpected(sync.error());
  auto poses = PoseLog::begin(folder);
  if (!poses) return tl::unexpected(poses.error());
  std::optional<PredictionLog> predictions;
  if (picture_time == PictureTime::predicted) {
    auto begun = PredictionLog::begin(folder, scene);
    if (!begun) return tl::unexpected(begun.error());
    predictions.emplace(std::move(*begun));
  }
  return GraphicsLogs{std::move(*frames), std::move(*sync), std::move(*poses), std::move(predictions)};
}

void GraphicsLogs::frame(const FrameRecord& frame, const FrameTimes& times, double trip_us,
                         const transport::ExchangeCounters& so_far) {
  frames.row(std::vector<std::string>{
      number_text(static_cast<double>(frame.number)), number_text(times.shown_s),
      trip_us > 0 ? number_text(trip_us) : "", frame.late ? "1" : "0", answer_name(frame.answer),
      number_text(frame.landmarks_used), number_text(to_seconds(times.busy) * 1e6),
      number_text(to_seconds(times.held) * 1e6), fmt::format("{}", so_far.unsent),
      fmt::format("{}", so_far.lost), fmt::format("{}", so_far.duplicated),
      fmt::format("{}", so_far.out_of_order)});
}

void GraphicsLogs::clocks(double t, double error_us, Duration stated, Duration offset) {
  sync.row(std::vector<double>{t, error_us, to_seconds(stated) * 1e6, to_seconds(offset)});
}

Expected<void> GraphicsLogs::finish() {
  for (auto done : {frames.finish(), sync.finish(), poses.finish()})
    if (!done) return done;
  return predictions ? predictions->finish() : Expected<void>{};
}

}  // namespace palpate::server::graphics
