// A frame of a game that was played, beside the truth about it.
#pragma once

#include <optional>

#include "palpate/evaluation/overlay.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::evaluation {

// What a frame showed, and what was true at the moment it was to show: its image's mid-exposure, or, of a
// predicted picture, when its light leaves the display.
struct PlayedFrame {
  server::graphics::FrameRecord record;  // without pixels
  CameraView truth;
  std::optional<CameraView> right_truth;  // of the second camera, where the record has its pose
  Vector3 shown_tip = Vector3::Zero();    // of the stylus, as it was drawn
  Vector3 true_tip = Vector3::Zero();
};

}  // namespace palpate::evaluation
