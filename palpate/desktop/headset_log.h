// What a headset's calibration needs (`palpate calibrate headset`): the head by the headset's runtime, and the camera by
// ours, while somebody moves.
//
// Files headset_head.csv (in HeadsetLocal, about a hundred a second) and headset_camera.csv (in World, one for each
// frame with a pose), poses as docs/conventions.md has them, time_s on the graphics host's clock from the first row on.
// One thread.
#pragma once

#include <filesystem>
#include <optional>

#include "palpate/core/csv_file.h"
#include "palpate/core/expected.h"
#include "palpate/headset/headset.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::desktop {

class HeadsetLog {
 public:
  static Expected<HeadsetLog> begin(const std::filesystem::path& folder);
  void frame(const server::graphics::FrameRecord& frame);
  // Every few milliseconds.
  void head(const headset::Headset& headset, Instant<GraphicsClock> now);
  Expected<void> finish();

 private:
  HeadsetLog(CsvFile head, CsvFile camera) : head_(std::move(head)), camera_(std::move(camera)) {}
  double time_s(Instant<GraphicsClock> time);

  CsvFile head_, camera_;
  std::optional<Instant<GraphicsClock>> begun_, last_;
};

}  // namespace palpate::desktop
