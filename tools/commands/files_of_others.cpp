#include "tools/commands/files_of_others.h"

#include <fmt/format.h>

#include "palpate/core/text.h"
#include "palpate/formats/tables.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {

Expected<device::PoseFile> read_poses(const std::string& path, const device::PoseFileOptions& options) {
  auto table = formats::read_poses(path, options);
  if (!table) return tl::unexpected(table.error());
  if (!table->form.empty()) notice(fmt::format("{}: {}", path, table->form));
  if (table->left_out > 0)
    notice(fmt::format("{}: {} left out in which the body was hidden, {} taken", path,
                       counted(table->left_out, "row"), table->file.poses.size()));
  return std::move(table->file);
}

Expected<device::PointFile> read_points(const std::string& path) {
  auto table = formats::read_points(path);
  if (!table) return tl::unexpected(table.error());
  if (!table->form.empty()) notice(fmt::format("{}: {}", path, table->form));
  return std::move(table->file);
}

}  // namespace palpate::tools::commands
