#include "palpate/server/graphics/shown_frame.h"

#include <unistd.h>

#include <utility>

#include "palpate/server/graphics/record_names.h"

namespace palpate::server::graphics {

transport::ShownPicture shown_picture(const FrameRecord& frame) {
  std::vector<transport::ShownPicture::Landmark> landmarks;
  const auto add = [&](const EyePose& eye, double left) {
    for (const FoundLandmark& one : eye.landmarks_found)
      if (landmarks.size() < transport::ShownPicture::kMostLandmarks)
        landmarks.push_back({one.place.x() + left, one.place.y(), one.used});
  };
  add(frame, 0.0);
  if (frame.right) add(*frame.right, 0.5 * frame.width);
  return {.writer = ::getpid(),
          .number = frame.number,
          .width = frame.width,
          .height = frame.height,
          .pose = pose_source_name(frame.pose_source),
          .landmarks_used = frame.landmarks_used,
          .landmarks_predicted = frame.landmarks_predicted,
          .landmark_rms_px = frame.landmark_rms_px,
          .expected_overlay_px = frame.expected_world_px,
          .landmarks = std::move(landmarks),
          .rgb = {}};
}

}  // namespace palpate::server::graphics
