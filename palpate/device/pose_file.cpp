#include "palpate/device/pose_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "palpate/core/file.h"
#include "palpate/core/file_form.h"
#include "palpate/core/lower_case.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/transform_sequence.h"
#include "palpate/device/turn_columns.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::device {

namespace fs = std::filesystem;

namespace {
constexpr double kMetresPerMm = 1e-3;
}

std::optional<PoseColumns> find_pose_columns(const CsvTable& table, const std::string& prefix) {
  for (const auto& [unit, scale] : {std::pair{"_mm", kMetresPerMm}, std::pair{"_m", 1.0}}) {
    const auto x = table.find(prefix + "x" + unit), y = table.find(prefix + "y" + unit),
               z = table.find(prefix + "z" + unit);
    const auto qw = table.find(prefix + "qw"), qx = table.find(prefix + "qx"), qy = table.find(prefix + "qy"),
               qz = table.find(prefix + "qz");
    if (x && y && z && qw && qx && qy && qz) return PoseColumns{*x, *y, *z, *qw, *qx, *qy, *qz, scale};
  }
  return std::nullopt;
}

namespace {

Expected<void> place_within_reach(const Vector3& place, const std::string& where) {
  const double largest = place.cwiseAbs().maxCoeff();
  if (largest <= kFarthestPlace) return {};
  return wrong_use("{}: is {:.3g} m away, at most {:g} m is expected; check the unit or remove the row",
                   where, largest, kFarthestPlace);
}

Expected<StampedPose> pose_from_numbers(const Vector3& translation, double w, double x, double y, double z,
                                        const std::string& where) {
  if (const auto near = place_within_reach(translation, where); !near) return tl::unexpected(near.error());
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  if (!(std::abs(length - 1.0) <= 0.02))
    return wrong_use(
        "{}: the quaternion has length {:.4g}, a rotation (length 1) is expected; remove or repair the row",
        where, length);
  StampedPose pose;
  pose.rotation = Quaternion(w / length, x / length, y / length, z / length);
  pose.translation = translation;
  return pose;
}

}  // namespace

Quaternion in_other_order(const Quaternion& told, bool told_scalar_first) {
  return told_scalar_first ? Quaternion(told.z(), told.w(), told.x(), told.y())
                           : Quaternion(told.x(), told.y(), told.z(), told.w());
}

std::vector<StampedPose> inverted(std::vector<StampedPose> poses) {
  for (auto& pose : poses) {
    pose.rotation = pose.rotation.conjugate();
    pose.translation = -(pose.rotation * pose.translation);
  }
  return poses;
}

Expected<StampedPose> pose_from_row(const CsvTable& table, std::size_t row, const PoseColumns& c) {
  const auto& v = table.rows[row];
  return pose_from_numbers(c.metres_per_unit * Vector3(v[c.x], v[c.y], v[c.z]), v[c.qw], v[c.qx], v[c.qy],
                           v[c.qz], fmt::format("{}:{}", table.source, table.line[row]));
}

Expected<StampedPose> pose_from_matrix(std::span<const double> m, double metres_per_unit,
                                       const std::string& where) {
  // One that was stored column by column has its place in the last row.
  if (m.size() == 16 && !(std::abs(m[12]) + std::abs(m[13]) + std::abs(m[14]) + std::abs(m[15] - 1.0) < 1e-6))
    return wrong_use(
        "{}: the last row is {:g} {:g} {:g} {:g}, 0 0 0 1 is expected; write the matrix row by row", where,
        m[12], m[13], m[14], m[15]);
  Matrix3 R;
  R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  const double defect = (R * R.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff();
  if (!(defect < 2e-3) || R.determinant() < 0)
    return wrong_use(
        "{}: the left 3x3 part is no rotation (R R' differs from 1 by {:.2g}, determinant {:.3g}); "
        "a rigid pose is expected",
        where, defect, R.determinant());
  StampedPose pose;
  pose.rotation = Quaternion(nearest_rotation(R).rotation).normalized();
  pose.translation = metres_per_unit * Vector3(m[3], m[7], m[11]);
  if (const auto near = place_within_reach(pose.translation, where); !near)
    return tl::unexpected(near.error());
  return pose;
}

namespace {

// Of a header that has x_mm, and is none of a pose.
tl::unexpected<Error> missing_columns(const CsvTable& table) {
  for (const char* name : {"y_m", "z_m"})
    if (table.find(name))
      return wrong_use("{}: the header has x_mm and {}; one unit is expected for x, y and z", table.source,
                       name);
  std::string missing, others;
  for (const char* name : {"y_mm", "z_mm", "qw", "qx", "qy", "qz"})
    if (!table.find(name)) missing += missing.empty() ? name : fmt::format(",{}", name);
  if (const auto turn = turn_columns(table.header); !turn.empty() && !table.find("qw"))
    others = fmt::format("; the turn is read from a quaternion alone, not from {}", turn);
  return wrong_use("{}: the header has x_mm but not {}, which {} needed too{}", table.source, missing,
                   missing.find(',') == std::string::npos ? "is" : "are", others);
}

// A column that looks like the time's, where none has the name that is read.
std::string unread_time(const CsvTable& table) {
  for (const auto& name : table.header) {
    const auto lower = lower_case(name);
    if (lower == "t" || lower.starts_with("time") || lower.starts_with("stamp")) return name;
  }
  return "";
}

Expected<void> read_segments(PoseFile& file, const std::string& column) {
  const auto at = file.table.require(column);
  if (!at) return tl::unexpected(at.error());
  for (std::size_t i = 0; i < file.poses.size(); ++i) {
    const auto& label = file.table.text[i][*at];
    if (label.empty() || file.table.rows[i][*at] == 0.0) continue;
    const auto known = std::find(file.segments.begin(), file.segments.end(), label);
    file.poses[i].segment = static_cast<int>(known - file.segments.begin());
    if (known == file.segments.end()) file.segments.push_back(label);
  }
  return {};
}

Expected<void> read_with_header(PoseFile& file) {
  CsvTable& table = file.table;
  auto columns = find_pose_columns(table, "");
  if (!columns) columns = find_pose_columns(table, "marker_");
  std::vector<std::size_t> numbers;
  if (!columns) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        if (const auto at = table.find(fmt::format("m{}{}", r, c))) numbers.push_back(*at);
    const std::array last_row{table.find("m30"), table.find("m31"), table.find("m32"), table.find("m33")};
    if (numbers.size() == 12 &&
        std::all_of(last_row.begin(), last_row.end(), [](const auto& at) { return at.has_value(); })) {
      for (const auto& at : last_row) numbers.push_back(*at);
    } else if (numbers.size() != 12) {
      const auto x = table.require("x_mm");
      if (!x) return wrong_use("{} (poses are x_mm,y_mm,z_mm,qw,qx,qy,qz or m00 ... m23)", x.error().message);
      return missing_columns(table);
    }
  }
  if (columns)
    numbers = {columns->x, columns->y, columns->z, columns->qw, columns->qx, columns->qy, columns->qz};
  file.left_out = table.leave_out_rows_without(numbers);
  if (table.rows.empty() && file.left_out > 0)
    return wrong_use("{}: the body is seen in none of {}", table.source, counted(file.left_out, "row"));
  if (const auto fine = table.require_numbers(numbers); !fine) return tl::unexpected(fine.error());
  // Poses that were made of a file without times have the column, and nothing in it.
  auto time = table.find("time_s");
  if (time && std::all_of(table.text.begin(), table.text.end(),
                          [&](const auto& cells) { return cells[*time].empty(); }))
    time.reset();
  file.has_time = time.has_value();
  if (!table.has("time_s")) file.unread_time = unread_time(table);
  if (time)
    if (const auto fine = table.require_within({*time}, kLatestTime); !fine)
      return tl::unexpected(fine.error());
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    Expected<StampedPose> pose;
    if (columns) {
      pose = pose_from_row(table, i, *columns);
    } else {
      std::vector<double> m;
      for (const auto at : numbers) m.push_back(table.rows[i][at]);
      pose = pose_from_matrix(m, kMetresPerMm, fmt::format("{}:{}", table.source, table.line[i]));
    }
    if (!pose) return tl::unexpected(pose.error());
    pose->time_s = time ? table.rows[i][*time] : static_cast<double>(i);
    file.poses.push_back(*pose);
  }
  return {};
}

Expected<void> read_without_header(PoseFile& file) {
  const CsvTable& table = file.table;
  const auto width = table.columns();
  if (width != 8 && width != 12 && width != 16)
    return wrong_use(
        "{}: has no header and {} columns; 8 (t,x,y,z,qx,qy,qz,qw in s and m), 12 or 16 (a matrix, mm) "
        "are expected",
        table.source, width);
  if (width == 8)
    if (const auto fine = table.require_within({0}, kLatestTime); !fine) return tl::unexpected(fine.error());
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& v = table.rows[i];
    const auto where = fmt::format("{}:{}", table.source, table.line[i]);
    auto pose = width == 8 ? pose_from_numbers(Vector3(v[1], v[2], v[3]), v[7], v[4], v[5], v[6], where)
                           : pose_from_matrix(v, kMetresPerMm, where);
    if (!pose) return tl::unexpected(pose.error());
    pose->time_s = width == 8 ? v[0] : static_cast<double>(i);
    file.poses.push_back(*pose);
  }
  if (width == 8) {
    file.has_time = true;
    std::stable_sort(file.poses.begin(), file.poses.end(),
                     [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
    const auto repeated = std::unique(file.poses.begin(), file.poses.end(),
                                      [](const auto& a, const auto& b) { return a.time_s == b.time_s; });
    file.poses.erase(repeated, file.poses.end());
    file.table = {.source = table.source};  // its rows no longer belong to the poses one by one
  }
  return {};
}

// The 16 numbers of one row-major 4x4 matrix, separated by blanks, commas, semicolons or line ends.
Expected<std::array<double, 16>> matrix_from_text(std::string_view text, const std::string& source) {
  std::array<double, 16> numbers{};
  std::size_t count = 0;
  while (true) {
    const auto start = text.find_first_not_of(" \t\r\n,;");
    if (start == std::string_view::npos) break;
    text.remove_prefix(start);
    const auto word = text.substr(0, text.find_first_of(" \t\r\n,;"));
    const auto digits = word.substr(word.front() == '+' ? 1 : 0);
    double value = 0.0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (code != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
      return wrong_use("{}: '{}' is not a finite number; a 4x4 matrix is expected", source,
                       excerpt(word, 16));
    if (count < numbers.size()) numbers[count] = value;
    ++count;
    text.remove_prefix(word.size());
  }
  if (count != numbers.size())
    return wrong_use("{}: holds {} numbers; the 16 of a 4x4 matrix are expected", source, count);
  return numbers;
}

// A folder's file that is no matrix: a table is read when it is named itself.
tl::unexpected<Error> no_matrix(const fs::path& folder, const fs::path& name, std::string_view content,
                                const Error& error) {
  const bool begins_with_a_name =
      !content.empty() && std::isalpha(static_cast<unsigned char>(content.front())) != 0;
  if (form_of(content) != FileForm::commas || !begins_with_a_name) return tl::unexpected(error);
  return wrong_use("{}: holds a table, {}; text files of one 4x4 matrix each are expected, name the table",
                   folder.string(), name.filename().string());
}

Expected<PoseFile> read_folder(const fs::path& folder) {
  std::vector<fs::path> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const auto extension = entry.path().extension();
    if (entry.is_regular_file(ignored) && (extension == ".txt" || extension == ".csv" || extension == ".dat"))
      names.push_back(entry.path());
  }
  if (names.empty())
    return wrong_use("{}: no .txt, .csv or .dat files in this folder; one 4x4 matrix each is expected",
                     folder.string());
  std::sort(names.begin(), names.end());
  PoseFile file;
  file.source = folder.string();
  std::string all;
  for (const auto& name : names) {
    const auto content = read_file(name);
    if (!content) return tl::unexpected(content.error());
    all += *content;
    auto pose = parse_matrix(*content, name.string());
    if (!pose) return no_matrix(folder, name, *content, pose.error());
    pose->time_s = static_cast<double>(file.poses.size());
    file.poses.push_back(*pose);
  }
  file.hash = content_hash(all);
  return file;
}

// What is said of numbers with blanks between them tells what the cells of a row would mean.
Expected<void> may_be_poses(std::string_view content, const std::string& source) {
  if (form_of(content) != FileForm::blanks) return may_be_table(content, source);
  return wrong_use(
      "{}: {}; commas are expected. Without header 8 cells a row are t,x,y,z,qx,qy,qz,qw in s and m, "
      "12 or 16 a matrix in mm; matrices of 4 lines belong into a folder, a file each",
      source, words_of(FileForm::blanks));
}

// Numbers, whatever stands between them; else what other programs write is named for what it is.
bool is_of_numbers(FileForm form) {
  constexpr std::array kForms = {FileForm::unknown,       FileForm::binary, FileForm::commas,
                                 FileForm::blanks,        FileForm::tabs,   FileForm::semicolons,
                                 FileForm::decimal_commas};
  return std::find(kForms.begin(), kForms.end(), form) != kForms.end();
}

}  // namespace

Expected<StampedPose> parse_matrix(std::string_view content, const std::string& source) {
  const auto numbers = matrix_from_text(content, source);
  if (const auto form = form_of(content); !numbers && !is_of_numbers(form))
    return wrong_use("{}: {}; the 16 numbers of a 4x4 matrix are expected", source, words_of(form));
  if (!numbers) return tl::unexpected(numbers.error());
  return pose_from_matrix(*numbers, kMetresPerMm, source);
}

Expected<PoseFile> read_poses(const fs::path& path, const PoseFileOptions& options) {
  std::error_code code;
  if (fs::is_directory(path, code)) {
    if (!options.segment_column.empty())
      return wrong_use("{}: a folder of matrices has no column '{}'", path.string(), options.segment_column);
    return read_folder(path);
  }
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_poses(*content, path.string(), options);
}

Expected<PoseFile> parse_poses(std::string_view content, std::string source, const PoseFileOptions& options) {
  PoseFile file;
  if (is_transform_sequence(content)) {
    auto poses = parse_transform_sequence(content, source, options.transform, &file.left_out);
    if (!poses) return tl::unexpected(poses.error());
    if (!options.segment_column.empty())
      return wrong_use("{}: a transform sequence has no column '{}'", source, options.segment_column);
    file.poses = std::move(*poses);
    file.has_time = true;
  } else {
    if (const auto fine = may_be_poses(content, source); !fine) return tl::unexpected(fine.error());
    if (!options.transform.empty())
      return wrong_use("{}: a transform name ({}) needs a transform sequence (.igs.mha)", source,
                       options.transform);
    CsvOptions csv;
    csv.text_columns.push_back("surface");
    if (!options.segment_column.empty()) csv.text_columns.push_back(options.segment_column);
    auto table = parse_csv(content, source, csv);
    if (!table) return tl::unexpected(table.error());
    file.table = std::move(*table);
    if (file.table.rows.empty())
      return wrong_use("{}: holds a header but no poses; at least one row is expected", source);
    const auto read = file.table.header.empty() ? read_without_header(file) : read_with_header(file);
    if (!read) return tl::unexpected(read.error());
    if (!options.segment_column.empty())
      if (const auto done = read_segments(file, options.segment_column); !done)
        return tl::unexpected(done.error());
  }
  file.source = std::move(source);
  file.hash = content_hash(content);
  return file;
}

}  // namespace palpate::device
