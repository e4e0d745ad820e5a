#include "drivers/network/recording.h"

#include <algorithm>

#include "palpate/core/file.h"
#include "palpate/device/pose_file.h"
#include "palpate/device/transform_sequence.h"

namespace palpate::drivers::network {
namespace {

// Samples of an arm's calibration hold a marker's pose in each row, too, but one from here and one from there: no
// tool moved so. Joint readings beside a pose of its own (a pivot that an arm held) are of a tool that did.
bool is_arm_samples(const CsvTable& table) {
  const bool joints = table.find("joint_1_deg") || table.find("joint_1_rad") || table.find("joint_1");
  return joints && !device::find_pose_columns(table, "") && device::find_pose_columns(table, "marker_");
}

}  // namespace

Expected<std::vector<RecordedPose>> read_recording(const std::filesystem::path& path,
                                                   const std::vector<std::string>& transforms) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  const bool sequence = device::is_transform_sequence(*content);
  auto names = transforms;
  if (names.empty()) names = sequence ? device::transform_names(*content) : std::vector<std::string>{"Tool"};
  if (names.empty()) names = {""};  // a sequence without any: the reader says so
  if (!sequence && names.size() > 1)
    return wrong_use("{}: holds one tool, {} names were given; one is expected", path.string(), names.size());
  std::vector<RecordedPose> recorded;
  for (const auto& name : names) {
    const auto file = device::parse_poses(*content, path.string(), {.transform = sequence ? name : ""});
    if (!file) return tl::unexpected(file.error());
    if (is_arm_samples(file->table))
      return wrong_use(
          "{}: holds samples of an arm, joint readings beside places of its marker (palpate calibrate arm "
          "--samples); "
          "a recording of a tool's poses is expected",
          path.string());
    if (!file->has_time) return wrong_use("{}: has no times; a column time_s is expected", path.string());
    for (const auto& pose : file->poses)
      recorded.push_back({pose.time_s, name, {pose.rotation, pose.translation}});
  }
  std::stable_sort(recorded.begin(), recorded.end(),
                   [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  if (recorded.front().time_s < 0.0)
    return wrong_use("{}: begins at {} s; times from 0 on are expected", path.string(),
                     recorded.front().time_s);
  return recorded;
}

Replay::Replay(std::vector<RecordedPose> poses, double speed, bool loop)
    : poses_(std::move(poses)), speed_(speed), loop_(loop) {
  const double length = poses_.back().time_s - poses_.front().time_s;
  // One mean step between the last pose and the first of the next round; a single pose comes each second.
  period_ = length > 0.0 ? length * (1.0 + 1.0 / static_cast<double>(poses_.size() - 1)) : 1.0;
}

double Replay::time_of_next() const { return poses_[next_].time_s + static_cast<double>(round_) * period_; }

std::optional<double> Replay::next_due() const {
  if (next_ == poses_.size()) return std::nullopt;
  return (time_of_next() - poses_.front().time_s) / speed_;
}

std::optional<RecordedPose> Replay::take(double elapsed) {
  const auto due = next_due();
  if (!due || *due > elapsed) return std::nullopt;
  RecordedPose pose = poses_[next_];
  pose.time_s = time_of_next();
  if (++next_ == poses_.size() && loop_) {
    next_ = 0;
    ++round_;
  }
  return pose;
}

}  // namespace palpate::drivers::network
