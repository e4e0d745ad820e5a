#include "palpate/server/session/frame_log.h"

#include <cmath>

namespace palpate::server::session {
namespace {

constexpr double kFirstPicturesS = 1.0;

}  // namespace

Expected<void> FrameLog::begin(const std::filesystem::path& folder, graphics::PictureTime picture_time,
                               const scene::SceneDescription& scene) {
  auto begun = graphics::GraphicsLogs::begin(folder, picture_time, scene);
  if (!begun) return tl::unexpected(begun.error());
  logs_.emplace(std::move(*begun));
  return {};
}

void FrameLog::add(const DrawnFrame& drawn, Instant<GraphicsClock> shown, GraphicsSide& side) {
  const graphics::FrameRecord& frame = *drawn.frame;
  double trip_us = 0.0;
  for (const double s : side.server().take_round_trips()) {
    trip_us = s * 1e6;
    trips_.add(seconds(s));
  }
  const double time_s = to_seconds(shown - begun_);
  for (const auto& error : side.server().take_prediction_errors()) {
    if (time_s > kFirstPicturesS) predictions_.add(error);
    if (logs_ && logs_->predictions) logs_->predictions->add(error);
  }
  if (logs_) {
    logs_->frame(frame, {time_s, drawn.ready - frame.begun, shown - drawn.ready}, trip_us,
                 side.link().counters());
    logs_->poses.add(frame, side.scene(), time_s);
  }
  if (side.server().sync().exchanges() > 0) add_clocks(time_s, side);
}

// The physics host's clock is this machine's own, undisguised: that is the truth to compare with.
void FrameLog::add_clocks(double time_s, const GraphicsSide& side) {
  const auto& model = side.server().sync().model();
  const auto here = clock_.now();
  const double error_us = static_cast<double>(model.to(here).ns() - clock_.to_monotonic(here)) * 1e-3;
  const Duration stated = model.uncertainty(here);
  sync_errors_.add(seconds(std::abs(error_us) * 1e-6));
  uncertainties_.add(stated);
  if (logs_) logs_->clocks(time_s, error_us, stated, model.offset(here));
}

void FrameLog::add_figures(Json& result, const GraphicsSide& side) const {
  result["sync"] = {{"offset_error_us_p99", sync_errors_.us(0.99)},
                    {"uncertainty_us", uncertainties_.us(0.5)},
                    {"exchanges", side.server().sync().exchanges()},
                    {"restarts", side.server().sync().restarts()}};
  if (predictions_.pictures() > 0) result["predicted"] = predictions_.json(side.scene());
}

Expected<void> FrameLog::finish() { return logs_ ? logs_->finish() : Expected<void>{}; }

}  // namespace palpate::server::session
