#include "tools/commands/files_of_others.h"

#include <fmt/format.h>

#include "palpate/core/text.h"
#include "palpate/formats/tables.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {

namespace {

void tell_left_out(const std::string& path, std::size_t left_out, std::size_t taken) {
  if (left_out > 0)
    notice(fmt::format("{}: {} left out in which the body was hidden, {} taken", path,
                       counted(left_out, "row"), taken));
}

}  // namespace

Expected<device::PoseFile> read_poses(const std::string& path, const device::PoseFileOptions& options) {
  auto table = formats::read_poses(path, options);
  if (!table) return tl::unexpected(table.error());
  if (!table->form.empty()) notice(fmt::format("{}: {}", path, table->form));
  tell_left_out(path, table->left_out, table->file.poses.size());
  return std::move(table->file);
}

Expected<device::PointFile> read_points(const std::string& path) {
  auto table = formats::read_points(path);
  if (!table) return tl::unexpected(table.error());
  if (!table->form.empty()) notice(fmt::format("{}: {}", path, table->form));
  return std::move(table->file);
}

Expected<device::ArmSampleFile> read_arm_samples(const std::string& path) {
  auto file = formats::read_arm_samples(path);
  if (file) tell_left_out(path, file->left_out, file->observations.size());
  return file;
}

}  // namespace palpate::tools::commands
