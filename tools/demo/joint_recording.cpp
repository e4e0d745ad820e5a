#include "tools/demo/joint_recording.h"

#include "palpate/core/text.h"
#include "palpate/record/recording_merge.h"

namespace palpate::tools::demo {

std::filesystem::path JointRecording::part(const char* server) const {
  if (!wanted()) return {};
  return file_.parent_path() / (file_.stem().string() + "." + server + file_.extension().string());
}

Expected<void> JointRecording::check() const {
  if (!wanted()) return {};
  for (const auto& file : {file_, physics(), graphics()}) {
    std::error_code code;
    if (std::filesystem::exists(std::filesystem::symlink_status(file, code)))
      return wrong_use("--record: {}: is there already; a new file is expected", one_line(file.string()));
  }
  return {};
}

Expected<void> JointRecording::join() const {
  if (!wanted()) return {};
  const auto merged = record::merge({physics(), graphics()}, file_);
  if (!merged)
    return refused("{}; the servers' recordings are {} and {}", merged.error().message,
                   one_line(physics().string()), one_line(graphics().string()));
  for (const auto& file : {physics(), graphics()}) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
  }
  return {};
}

}  // namespace palpate::tools::demo
