// What the frames of a graphics process show of themselves: round trips, clocks, predictions, as figures at the end and, where a
// folder is given, frame by frame in files (docs/raw-files.md).
//
// Thread: that of the frame loop.
#pragma once

#include <filesystem>
#include <optional>

#include "palpate/core/json.h"
#include "palpate/server/graphics/graphics_figures.h"
#include "palpate/server/graphics/prediction_figures.h"
#include "palpate/server/session/graphics_side.h"

namespace palpate::server::session {

// A picture that is ready for the display, and when it is to go there.
struct DrawnFrame {
  const graphics::FrameRecord* frame;  // until the next frame is finished
  Instant<GraphicsClock> ready, due;
};

class FrameLog {
 public:
  // The clock must outlive it.
  explicit FrameLog(const MonotonicClock<GraphicsClock>& clock) : clock_(clock) {}

  // Into files, too. Refused where one cannot be begun.
  Expected<void> begin(const std::filesystem::path& folder, graphics::PictureTime picture_time,
                       const scene::SceneDescription& scene);
  // Times count from here.
  void set_begun(Instant<GraphicsClock> begun) { begun_ = begun; }
  // A picture was handed to the display.
  void add(const DrawnFrame& drawn, Instant<GraphicsClock> shown, GraphicsSide& side);
  const graphics::Quantiles& trips() const { return trips_; }  // round trips
  // Adds `sync` and, where there are some, `predicted`.
  void add_figures(Json& result, const GraphicsSide& side) const;
  // Puts the files in place.
  Expected<void> finish();

 private:
  void add_clocks(double time_s, const GraphicsSide& side);

  const MonotonicClock<GraphicsClock>& clock_;
  std::optional<graphics::GraphicsLogs> logs_;
  graphics::PredictionFigures predictions_;
  graphics::Quantiles trips_, sync_errors_, uncertainties_;
  Instant<GraphicsClock> begun_;
};

}  // namespace palpate::server::session
