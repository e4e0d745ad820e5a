#include <algorithm>
#include <cmath>
#include <memory>

#include "palpate/calibration/findings/delay.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/device/point_file.h"
#include "palpate/device/pose_file.h"
#include "palpate/device/transform_sequence.h"
#include "palpate/formats/tables.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/files_of_others.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

struct DelayArguments {
  ResultOptions result;
  std::string from, to, from_column, to_column;
  double longest_s = 0.0;  // 0: any delay
};

struct Recording {
  calibration::Motion motion;
  std::string kind, hash;          // "poses", "points" or "column NAME"
  std::size_t without_number = 0;  // rows left out
};

// Where a table is read for one number a row, cells of any column may be words: only two columns matter.
Expected<CsvTable> any_table(const std::string& path, const std::string& content) {
  return parse_csv(content, path, {.text_columns = {"*"}});
}

Expected<Recording> column_recording(const std::string& path, const std::string& content,
                                     const std::string& name) {
  const auto table = any_table(path, content);
  if (!table) return tl::unexpected(table.error());
  const auto time = table->require("time_s"), column = table->require(name);
  if (!column) return tl::unexpected(column.error());
  if (!time) return tl::unexpected(time.error());
  if (name == "time_s") return wrong_use("{}: time_s is the time itself; another column is expected", path);
  if (const auto fine = table->require_within({*time}, kLatestTime); !fine)
    return tl::unexpected(fine.error());
  constexpr double kLargest = 1e100;
  if (const auto fine = table->require_within({*column}, kLargest); !fine)
    return tl::unexpected(fine.error());
  std::vector<double> time_s, values;
  for (const auto& row : table->rows) {
    if (!std::isfinite(row[*time]) || !std::isfinite(row[*column])) continue;
    time_s.push_back(row[*time]);
    values.push_back(row[*column]);
  }
  if (values.empty())
    return wrong_use("{}: no row has numbers both in time_s and in {}; a column of numbers is expected", path,
                     excerpt(name));
  const auto without = table->rows.size() - values.size();
  // To size 1: a squared number of another unit may be too large or too small for a double.
  const double largest = std::abs(*std::max_element(
      values.begin(), values.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  if (largest > 0.0)
    for (auto& value : values) value /= largest;
  return Recording{calibration::motion_of_signal(fmt::format("{}'s {}", path, excerpt(name)), time_s, values),
                   "column " + excerpt(name), content_hash(content), without};
}

Expected<Recording> point_recording(const std::string& path, const std::string& content) {
  const auto file = device::parse_points(content, path);
  if (!file) return tl::unexpected(file.error());
  const auto time = file->table.require("time_s");
  if (!time) return tl::unexpected(time.error());
  if (const auto fine = file->table.require_within({*time}, kLatestTime); !fine)
    return tl::unexpected(fine.error());
  std::vector<calibration::TimedPoint> points;
  for (std::size_t i = 0; i < file->points.size(); ++i)
    points.push_back({file->table.rows[i][*time], file->points[i]});
  return Recording{calibration::motion_of_points(path, points), "points", file->hash};
}

Expected<Recording> pose_recording(const std::string& path, const Expected<device::PoseFile>& file) {
  if (!file) return tl::unexpected(file.error());
  if (!file->has_time) return wrong_use("{}: has no times; a column time_s is expected", path);
  return Recording{calibration::motion_of_poses(path, file->poses), "poses", file->hash};
}

std::string names_of(const CsvTable& table) {
  constexpr std::size_t kMostNames = 12;
  std::vector<std::string> names;
  for (const auto& name : table.header)
    if (name != "time_s" && names.size() < kMostNames) names.push_back(excerpt(name));
  return fmt::format("{}{}", fmt::join(names, ", "), table.header.size() > kMostNames + 1 ? ", ..." : "");
}

// A named column, else poses or points, told apart by the header.
Expected<Recording> read_recording(const std::string& path, const std::string& column, const char* option) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  if (device::is_transform_sequence(*content)) {
    if (!column.empty())
      return wrong_use("{}: a transform sequence has no column '{}'", path, excerpt(column));
    return pose_recording(path, device::parse_poses(*content, path));
  }
  if (!column.empty()) return column_recording(path, *content, column);
  if (formats::is_of_others(*content)) return pose_recording(path, read_poses(path));
  const auto table = any_table(path, *content);
  if (!table) return tl::unexpected(table.error());
  const bool places = table->has("x_mm") || table->has("x_m");
  if (table->header.empty() || table->has("qw") || table->has("marker_qw") || table->has("m00"))
    return pose_recording(path, device::parse_poses(*content, path));
  if (places) return point_recording(path, *content);
  return wrong_use(
      "{}: holds neither poses (x_mm,y_mm,z_mm,qw,qx,qy,qz) nor points (x_mm,y_mm,z_mm); name the column "
      "that "
      "follows the motion with {}: {}",
      path, option, names_of(*table));
}

Result result_of(const DelayArguments& options, const calibration::MotionDelay& found, const Recording& from,
                 const Recording& to) {
  auto warnings = found.warnings;
  for (const auto& recording : {from, to})
    if (recording.without_number > 0)
      warnings.push_back(fmt::format("{}: {} without a number left out", recording.motion.name,
                                     counted(recording.without_number, "row")));
  Result result{calibration::findings::delay_json(found, warnings), {}, {}};
  result.json["data"] = {{"from", {{"file", options.from}, {"kind", from.kind}, {"hash", from.hash}}},
                         {"to", {{"file", options.to}, {"kind", to.kind}, {"hash", to.hash}}}};
  result.summary = {fmt::format("delay        {:.5f} +- {:.5f} s (to time = from time + delay)",
                                found.delay_s, found.delay_std_s),
                    fmt::format("correlation  {:.5f} over {:.1f} s, {}", found.correlation, found.overlap_s,
                                counted(static_cast<std::size_t>(found.samples), "sample"))};
  for (const auto& warning : warnings) result.summary.push_back("warning: " + warning);
  return result;
}

Expected<void> run_delay(const DelayArguments& options) {
  if (const auto rig = start_rig(options.result); !rig) return tl::unexpected(rig.error());
  const auto from = read_recording(options.from, options.from_column, "--from-column");
  if (!from) return tl::unexpected(from.error());
  const auto to = read_recording(options.to, options.to_column, "--to-column");
  if (!to) return tl::unexpected(to.error());
  if (from->hash == to->hash && from->kind == to->kind)
    return wrong_use("{}: holds the same as {}; two recordings of one motion are expected", options.to,
                     options.from);
  calibration::MotionDelayOptions how;
  if (options.longest_s > 0.0) how.longest_s = options.longest_s;
  const auto found = calibration::estimate_motion_delay(from->motion, to->motion, how);
  if (!found) return tl::unexpected(found.error());
  return write_result(options.result, result_of(options, *found, *from, *to));
}

}  // namespace

void add_calibrate_delay(CLI::App& calibrate) {
  auto options = std::make_shared<DelayArguments>();
  auto* command = calibrate.add_subcommand("delay", "The time offset of two recordings of one motion");
  command->add_option("--from", options->from, "Poses, points, or a table with time_s")->type_name("FILE");
  command->add_option("--to", options->to, "The same motion by another clock; to time = from time + delay")
      ->type_name("FILE");
  command->add_option("--from-column", options->from_column, "The column of --from that follows the motion")
      ->type_name("NAME");
  command->add_option("--to-column", options->to_column, "The column of --to that follows the motion")
      ->type_name("NAME");
  command
      ->add_option("--longest-s", options->longest_s,
                   "Look for delays of at most this, either sign; for motions that repeat themselves")
      ->check(above_zero())
      ->type_name("S");
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--from", options->from, "from");
  tables->add("--to", options->to, "to");
  tables->add_options(*command, false);
  on(command, tables, [options] { return run_delay(*options); });
}

}  // namespace palpate::tools::commands
