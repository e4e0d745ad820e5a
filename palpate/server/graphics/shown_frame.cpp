#include "palpate/server/graphics/shown_frame.h"

#include <unistd.h>

#include "palpate/server/graphics/record_names.h"

namespace palpate::server::graphics {

transport::ShownPicture shown_picture(const FrameRecord& frame) {
  return {.writer = ::getpid(),
          .number = frame.number,
          .width = frame.width,
          .height = frame.height,
          .pose = pose_source_name(frame.pose_source),
          .landmarks_used = frame.landmarks_used,
          .landmarks_predicted = frame.landmarks_predicted,
          .landmark_rms_px = frame.landmark_rms_px,
          .expected_overlay_px = frame.expected_world_px,
          .rgb = {}};
}

}  // namespace palpate::server::graphics
