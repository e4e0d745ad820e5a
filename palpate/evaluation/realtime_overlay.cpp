#include "palpate/evaluation/realtime_overlay.h"

#include <unordered_map>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/math/csv_cells.h"

namespace palpate::evaluation {
namespace {

// A table of numbers of which some may be missing; every column that is asked for has to be there.
class RawTable {
 public:
  static Expected<RawTable> read(const std::filesystem::path& path, const Cells& columns) {
    CsvOptions gaps;
    gaps.text_columns = {"*"};
    auto table = read_csv(path, gaps);
    if (!table) return tl::unexpected(table.error());
    for (const auto& column : columns)
      if (const auto at = table->require(column); !at) return tl::unexpected(at.error());
    return RawTable(std::move(*table));
  }
  std::size_t rows() const { return table_.rows.size(); }
  const Cells& header() const { return table_.header; }
  const Cells& cells(std::size_t row) const { return table_.text[row]; }
  double number(std::size_t row, const std::string& column) const {
    return table_.rows[row][*table_.find(column)];
  }
  const std::string& text(std::size_t row, const std::string& column) const {
    return table_.text[row][*table_.find(column)];
  }
  std::optional<double> maybe(std::size_t row, const std::string& column) const {
    return text(row, column).empty() ? std::nullopt : std::optional(number(row, column));
  }
  std::optional<Vector3> point(std::size_t row, const std::string& of) const {
    if (text(row, of + "_x_m").empty()) return std::nullopt;
    return Vector3(number(row, of + "_x_m"), number(row, of + "_y_m"), number(row, of + "_z_m"));
  }
  std::optional<Pose<World, CameraOptical>> pose(std::size_t row, const std::string& of) const {
    const auto place = point(row, of);
    if (!place) return std::nullopt;
    const Quaternion turn(number(row, of + "_qw"), number(row, of + "_qx"), number(row, of + "_qy"),
                          number(row, of + "_qz"));
    return Pose<World, CameraOptical>{turn.normalized(), *place};
  }

 private:
  explicit RawTable(CsvTable table) : table_(std::move(table)) {}
  CsvTable table_;
};

// A picture as the files tell of it; none where a pose is missing in either.
std::optional<PlayedFrame> played_frame(const RawTable& drawn, std::size_t i, const RawTable& taken,
                                        std::size_t k, const device::CameraModel& true_lens) {
  const auto pose = drawn.pose(i, "cam"), true_pose = taken.pose(k, "cam");
  const auto true_tip = taken.point(k, "tip");
  if (!pose || !true_pose || !true_tip) return std::nullopt;
  PlayedFrame frame;
  frame.truth = {true_lens, *true_pose};
  frame.record.X_world_camera = *pose;
  if (const auto tracker = drawn.pose(i, "tracker_cam")) {
    frame.record.have_tracker = true;
    frame.record.X_world_camera_tracker = *tracker;
  }
  frame.record.expected_world_px = drawn.maybe(i, "expected_world_px");
  frame.record.late = drawn.number(i, "late") != 0.0;
  if (const auto tip = drawn.point(i, "tip")) {
    frame.record.have_state = true;
    frame.shown_tip = *tip;
    frame.true_tip = *true_tip;
  } else {
    frame.true_tip = true_pose->translation;  // where no camera sees it: no tip was drawn, none is judged
  }
  return frame;
}

}  // namespace

OverlayCase overlay_case(const sim::config::WorldFile& world, std::uint64_t seed, const rig::Rig& rig) {
  const auto truth = sim::draw_truth(world, seed);
  return {.lens = rig.camera->model, .true_lens = truth.lens, .points = check_points(truth, rig)};
}

Expected<Json> evaluate_overlay(const std::filesystem::path& poses, const std::filesystem::path& truth,
                                const OverlayCase& against) {
  const auto drawn =
      RawTable::read(poses, joined({{"camera_frame", "time_s", "late", "pose_source", "expected_world_px"},
                                    pose_columns("cam"),
                                    pose_columns("tracker_cam"),
                                    point_columns("tip")}));
  if (!drawn) return tl::unexpected(drawn.error());
  const auto taken = RawTable::read(truth, joined({{"frame"}, pose_columns("cam"), point_columns("tip")}));
  if (!taken) return tl::unexpected(taken.error());
  std::unordered_map<std::string, std::size_t> row_of;
  for (std::size_t i = 0; i < taken->rows(); ++i) row_of[taken->text(i, "frame")] = i;

  std::vector<PlayedFrame> counted;
  CsvWriter judged(joined({drawn->header(), {"world_px", "world_px_tracker", "tip_px"}}));
  Json sources = {{"none", 0}, {"tracker", 0}, {"refined", 0}, {"landmarks", 0}};
  std::size_t unjudged = 0;
  for (std::size_t i = 0; i < drawn->rows(); ++i) {
    const auto known = row_of.find(drawn->text(i, "camera_frame"));
    auto frame = known == row_of.end() ? std::nullopt
                                       : played_frame(*drawn, i, *taken, known->second, against.true_lens);
    Cells cells = drawn->cells(i);
    const FrameErrors errors =
        frame ? overlay_of_play({*frame}, against.lens, against.points).frames.front() : FrameErrors{};
    put(cells, errors.world_px);
    put(cells, errors.world_px_tracker);
    put(cells, errors.tip_px);
    judged.row(cells);
    if (!frame) ++unjudged;
    if (!frame || drawn->number(i, "time_s") < against.warm_up_s) continue;
    counted.push_back(std::move(*frame));
    const auto& source = drawn->text(i, "pose_source");
    sources[source] = sources.value(source, 0) + 1;
  }
  if (auto done = write_file(poses, judged.content()); !done) return tl::unexpected(done.error());

  const auto overlay = overlay_of_play(counted, against.lens, against.points);
  ErrorSummary in_time, belated;
  std::size_t late = 0;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    late += counted[i].record.late ? 1 : 0;
    if (const auto& e = overlay.frames[i].tip_px) (counted[i].record.late ? belated : in_time).add(*e);
  }
  Json json = overlay_figures(overlay);
  if (!in_time.empty()) json["tip_px_rms_in_time"] = in_time.rms();
  if (!belated.empty()) json["tip_px_rms_late"] = belated.rms();
  json["frames"] = counted.size();
  json["late"] = late;
  json["unjudged"] = unjudged;
  json["warm_up_s"] = against.warm_up_s;
  json["check_points"] = against.points.size();
  json["pose_from"] = sources;
  return json;
}

}  // namespace palpate::evaluation
