#include "palpate/desktop/headset_log.h"

#include <string>
#include <vector>

#include "palpate/core/units.h"

namespace palpate::desktop {
namespace {

constexpr Duration kHeadEvery = std::chrono::milliseconds(10);
// Asked for so late that it lies between two poses that the runtime has told.
constexpr Duration kHeadBehind = std::chrono::milliseconds(40);

std::vector<std::string> pose_header() { return {"time_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"}; }

std::vector<double> pose_row(double time_s, const Quaternion& q, const Vector3& p) {
  return {time_s,
          kMillimetresPerMetre * p.x(),
          kMillimetresPerMetre * p.y(),
          kMillimetresPerMetre * p.z(),
          q.w(),
          q.x(),
          q.y(),
          q.z()};
}

}  // namespace

Expected<HeadsetLog> HeadsetLog::begin(const std::filesystem::path& folder) {
  auto head = CsvFile::begin(folder / "headset_head.csv", pose_header());
  if (!head) return tl::unexpected(head.error());
  auto camera = CsvFile::begin(folder / "headset_camera.csv", pose_header());
  if (!camera) return tl::unexpected(camera.error());
  return HeadsetLog(std::move(*head), std::move(*camera));
}

double HeadsetLog::time_s(Instant<GraphicsClock> time) {
  if (!begun_) begun_ = time;
  return to_seconds(time - *begun_);
}

void HeadsetLog::frame(const server::graphics::FrameRecord& frame) {
  if (frame.pose_source == server::graphics::PoseSource::none) return;
  camera_.row(
      pose_row(time_s(frame.image_time), frame.X_world_camera.rotation, frame.X_world_camera.translation));
}

void HeadsetLog::head(const headset::Headset& headset, Instant<GraphicsClock> now) {
  if (last_ && now - *last_ < kHeadEvery) return;
  const auto at = now - kHeadBehind;
  const auto head = headset.head_at(at);
  if (!head.usable()) return;
  last_ = now;
  head_.row(pose_row(time_s(at), head.X_local_view.rotation, head.X_local_view.translation));
}

Expected<void> HeadsetLog::finish() {
  if (auto done = head_.finish(); !done) return done;
  return camera_.finish();
}

}  // namespace palpate::desktop
