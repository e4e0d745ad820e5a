#include "palpate/formats/tables.h"

#include <optional>
#include <string>
#include <utility>

#include "palpate/core/file.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/read.h"

namespace palpate::formats {
namespace {

template <typename Kind>
Expected<Kind> only(Expected<Content> read, const std::string& source, std::string_view expected,
                    std::string& form) {
  if (!read) return tl::unexpected(read.error());
  auto* value = std::get_if<Kind>(&read->value);
  if (value == nullptr) return wrong_use("{}: is {}; {} are expected", source, read->form, expected);
  form = read->form + ": " + read->told;
  return std::move(*value);
}

// What a reader of this program's tables is given: the content, or the same with commas.
struct OwnTable {
  std::optional<std::string> rewritten;
  std::string_view original;

  std::string_view text() const { return rewritten ? std::string_view(*rewritten) : original; }
};

// Nothing where it is a table of others.
std::optional<OwnTable> own_table(std::string_view content) {
  if (!is_of_others(content)) return OwnTable{std::nullopt, content};
  if (!has_own_columns(content)) return std::nullopt;
  auto rewritten = with_commas(content);
  if (!rewritten) return std::nullopt;
  return OwnTable{std::move(rewritten), content};
}

}  // namespace

Expected<PoseTable> read_poses(const std::filesystem::path& path, const device::PoseFileOptions& options) {
  std::error_code code;
  PoseTable table;
  const auto take = [&](Expected<device::PoseFile> read) -> Expected<PoseTable> {
    if (!read) return tl::unexpected(read.error());
    table.left_out = read->left_out;
    table.file = std::move(*read);
    return table;
  };
  if (std::filesystem::is_directory(path, code)) return take(device::read_poses(path, options));
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  const std::string source = path.string();
  if (const auto own = own_table(*content)) {
    auto read = take(device::parse_poses(own->text(), source, options));
    if (read) read->file.hash = content_hash(*content);
    return read;
  }
  ReadOptions how;
  how.tool = options.transform;
  auto poses = only<Poses>(parse(*content, source, how), source, "poses", table.form);
  if (!poses) return tl::unexpected(poses.error());
  if (!options.segment_column.empty())
    return wrong_use("{}: is {}, which has no column '{}'", source, table.form, options.segment_column);
  table.left_out = poses->left_out;
  table.file.source = source;
  table.file.hash = content_hash(*content);
  table.file.has_time = poses->has_time;
  table.file.poses = std::move(poses->poses);
  return table;
}

Expected<PointTable> read_points(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  const std::string source = path.string();
  PointTable table;
  if (const auto own = own_table(*content)) {
    auto read = device::parse_points(own->text(), source);
    if (!read) return tl::unexpected(read.error());
    table.file = std::move(*read);
    table.file.hash = content_hash(*content);
    return table;
  }
  auto points = only<Points>(parse(*content, source), source, "points", table.form);
  if (!points) return tl::unexpected(points.error());
  table.file.source = source;
  table.file.hash = content_hash(*content);
  table.file.points = std::move(points->places);
  table.file.labels = std::move(points->labels);
  return table;
}

Expected<device::ArmSampleFile> read_arm_samples(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  auto file = device::parse_arm_samples(OwnTable{with_commas(*content), *content}.text(), path.string());
  if (file) file->hash = content_hash(*content);
  return file;
}

}  // namespace palpate::formats
