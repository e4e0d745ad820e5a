// Rows of numbers without a header: trajectories of TUM and KITTI, matrices as MATLAB saves them.
//
// TUM (Sturm and others, IROS 2012): t x y z qx qy qz qw, s and m, blanks between. KITTI odometry (Geiger and others, CVPR 2012):
// 12 numbers, a 3x4 matrix row by row, m, without times. 4 lines of 4 numbers: one 4x4 matrix, or one after the other, mm, as
// this program and PLUS have it.
#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/pose_numbers.h"
#include "palpate/formats/internal/text_table.h"

namespace palpate::formats {
namespace {

using Row = std::vector<double>;

constexpr double kShortForMm = 1e-3;  // m; nobody moves a camera by so little

// The width of all rows; 0 where they differ.
std::size_t width_of(const NumberRows& table) {
  const std::size_t width = table.rows.empty() ? 0 : table.rows.front().size();
  return std::all_of(table.rows.begin(), table.rows.end(),
                     [&](const Row& row) { return row.size() == width; })
             ? width
             : 0;
}

std::string place(const Source& source, int line) { return fmt::format("{}:{}", source.name, line); }

Expected<Content> trajectory_of_tum(const Source& source, const NumberRows& table) {
  Poses poses;
  poses.has_time = true;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const Row& v = table.rows[i];
    const PoseNumbers numbers = {v[1], v[2], v[3], v[7], v[4], v[5], v[6]};
    if (is_hidden(numbers)) {
      ++poses.left_out;
      continue;
    }
    if (!is_whole(numbers))
      return wrong_use(
          "{}: a part of the pose is missing; all of it, or nothing where the body was hidden, is expected",
          place(source, table.line[i]));
    auto pose = pose_of(numbers, 1.0, place(source, table.line[i]));
    if (!pose) return tl::unexpected(pose.error());
    if (!(std::abs(v[0]) <= kLatestTime))
      return wrong_use("{}: the time is {:g}; seconds are expected: are these nanoseconds?",
                       place(source, table.line[i]), v[0]);
    pose->time_s = v[0];
    poses.poses.push_back(*pose);
  }
  return Content{"a TUM trajectory", "t x y z qx qy qz qw, s and m", poses};
}

Expected<Content> matrices(const Source& source, const NumberRows& table, double scale, std::string form,
                           std::string told) {
  Poses poses;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (std::all_of(table.rows[i].begin(), table.rows[i].end(), [](double v) { return std::isnan(v); })) {
      ++poses.left_out;
      continue;
    }
    if (std::any_of(table.rows[i].begin(), table.rows[i].end(), [](double v) { return std::isnan(v); }))
      return wrong_use("{}: a part of the matrix is missing", place(source, table.line[i]));
    auto pose = device::pose_from_matrix(table.rows[i], scale, place(source, table.line[i]));
    if (!pose) return tl::unexpected(pose.error());
    pose->time_s = static_cast<double>(i);
    poses.poses.push_back(*pose);
  }
  return Content{std::move(form), std::move(told), poses};
}

bool is_last_row(const Row& row) { return row == Row{0.0, 0.0, 0.0, 1.0}; }

// 4 lines of 4 each.
Expected<Content> blocks(const Source& source, const NumberRows& table) {
  const double scale = source.options.metres_per_unit > 0 ? source.options.metres_per_unit : 1e-3;
  const std::string unit = scale == 1.0 ? "m" : "mm";
  for (std::size_t i = 3; i < table.rows.size(); i += 4)
    if (!is_last_row(table.rows[i]))
      return wrong_use("{}: 0 0 0 1 are expected in the last line of a 4x4 matrix",
                       place(source, table.line[i]));
  if (table.rows.size() == 4) {
    Transform transform;
    for (Eigen::Index r = 0; r < 4; ++r)
      for (Eigen::Index c = 0; c < 4; ++c)
        transform.matrix(r, c) = table.rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
    transform.matrix.topRightCorner<3, 1>() *= scale;
    const auto sound = transform_of(transform.matrix, source.name);
    if (!sound) return tl::unexpected(sound.error());
    const double length = sound->matrix.topRightCorner<3, 1>().norm();  // m
    const bool doubtful = !(source.options.metres_per_unit > 0) && length > 0.0 && length < kShortForMm;
    return Content{"a 4x4 matrix",
                   doubtful ? fmt::format("mm, and so moves by {:.3g} mm only; --unit m if these are metres",
                                          mm_from_metres(length))
                            : unit,
                   *sound};
  }
  NumberRows whole;
  for (std::size_t i = 0; i < table.rows.size(); i += 4) {
    Row m;
    for (std::size_t r = 0; r < 4; ++r) m.insert(m.end(), table.rows[i + r].begin(), table.rows[i + r].end());
    whole.rows.push_back(std::move(m));
    whole.line.push_back(table.line[i]);
  }
  return matrices(source, whole, scale, "4x4 matrices, one after the other", unit);
}

// Who wrote these is not told by the numbers, and with it their unit is not.
Expected<Content> matrices_of_a_row(const Source& source, const NumberRows& table, std::size_t width) {
  const double scale = source.options.metres_per_unit;
  if (scale > 0) return matrices(source, table, scale, "matrices, one a row", scale == 1.0 ? "m" : "mm");
  if (width == 12 && separation_of(source.content).separator == ' ')
    return matrices(source, table, 1.0, "a KITTI trajectory", "rows of 3x4 matrices, m");
  return wrong_use(
      "{}: has rows of {} numbers, which are matrices; their unit is needed: palpate convert --unit mm, or m",
      source.name, width);
}

}  // namespace

bool is_rows_of_numbers(std::string_view content) {
  const Separation separation = separation_of(content);
  int looked = 0;
  while (looked < 5) {
    const auto raw = next_line(content);
    if (!raw) break;
    const auto line = trimmed(*raw);
    if (line.empty() || line.front() == '#' || line.front() == '%') continue;
    ++looked;
    const auto cells = cells_of(line, separation.separator, 64);
    if (cells.size() < 3 || !std::all_of(cells.begin(), cells.end(), [&](std::string_view cell) {
          return is_missing(cell) || number_of(cell, separation.decimal_commas).has_value();
        }))
      return false;
  }
  return looked > 0;
}

Expected<Content> read_rows_of_numbers(const Source& source) {
  const auto table = number_rows(source.content, source.name);
  if (!table) return tl::unexpected(table.error());
  const std::size_t width = width_of(*table);
  if (width == 8) return trajectory_of_tum(source, *table);
  if (width == 12 || width == 16) return matrices_of_a_row(source, *table, width);
  if (width == 4 && table->rows.size() % 4 == 0) return blocks(source, *table);
  if (width == 3) {
    if (!(source.options.metres_per_unit > 0))
      return wrong_use(
          "{}: has rows of 3 numbers, which are points; their unit is needed: palpate convert --unit mm, or "
          "m",
          source.name);
    Points points;
    for (std::size_t i = 0; i < table->rows.size(); ++i) {
      const Row& v = table->rows[i];
      const auto at =
          place_of(source.options.metres_per_unit * Vector3(v[0], v[1], v[2]), place(source, table->line[i]));
      if (!at) return tl::unexpected(at.error());
      points.places.push_back(*at);
    }
    return Content{"points, one a row", source.options.metres_per_unit == 1.0 ? "m" : "mm", points};
  }
  return wrong_use(
      "{}: has no header and {}; 8 numbers a row (t x y z qx qy qz qw, s and m), 12 or 16 (a matrix), 3 (a "
      "point) or 4 lines of 4 "
      "are expected",
      source.name, width == 0 ? "rows of different lengths" : fmt::format("rows of {} numbers", width));
}

}  // namespace palpate::formats
