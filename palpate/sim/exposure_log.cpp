#include "palpate/sim/exposure_log.h"

#include "palpate/math/csv_cells.h"

namespace palpate::sim {

Expected<ExposureLog> ExposureLog::begin(const std::filesystem::path& path) {
  auto rows = CsvFile::begin(path, joined({{"frame", "mid_exposure_monotonic_ns"},
                                           pose_columns("cam"),
                                           point_columns("tip"),
                                           {"camera_stamp_ns"}}));
  if (!rows) return tl::unexpected(rows.error());
  return ExposureLog(std::move(*rows));
}

void ExposureLog::add(std::uint64_t frame, std::int64_t mid_exposure_ns, const TrueView& view,
                      Instant<CameraClock> stamp) {
  Cells row{fmt::format("{}", frame), fmt::format("{}", mid_exposure_ns)};
  put(row, view.X_world_camera);
  put(row, true_tip(view));
  row.push_back(fmt::format("{}", stamp.ns()));
  rows_.row(row);
}

}  // namespace palpate::sim
