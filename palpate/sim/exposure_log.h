// What the simulated laboratory knows of each image and tells nobody while it runs: when it was taken, where
// the camera and the stylus tip truly were then. A file for whoever judges delays and overlay errors after
// the play (latency_probe.h, realtime_overlay.h); no server reads it.
//
// Columns: frame (the camera's own count), mid_exposure_monotonic_ns (the machine's monotonic clock),
// cam_x_m ... cam_qz (camera in World), tip_x_m, tip_y_m, tip_z_m (World), camera_stamp_ns (the same moment by the
// camera's own clock, which its images carry wherever they go). One thread.
#pragma once

#include <cstdint>
#include <filesystem>

#include "palpate/core/csv_file.h"
#include "palpate/core/expected.h"
#include "palpate/sim/true_view.h"
#include "palpate/time/instant.h"

namespace palpate::sim {

class ExposureLog {
 public:
  static Expected<ExposureLog> begin(const std::filesystem::path& path);
  // `view`: as it was in the middle of the exposure, which the camera stamps with `stamp`.
  void add(std::uint64_t frame, std::int64_t mid_exposure_ns, const TrueView& view,
           Instant<CameraClock> stamp);
  Expected<void> finish() { return rows_.finish(); }

 private:
  explicit ExposureLog(CsvFile rows) : rows_(std::move(rows)) {}
  CsvFile rows_;
};

}  // namespace palpate::sim
