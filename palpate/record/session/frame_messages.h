// What a graphics server knew and did for one picture, and how the clocks beside its own go, as messages of
// palpate_recording.proto. Pure. decode checks what it reads as any file of others.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/math/pose.h"
#include "palpate/time/instant.h"

namespace palpate::record::session {

// As graphics::FrameRecord says it, apart from the picture.
struct RecordedFrame {
  enum class PoseSource : std::uint8_t { none, tracker, refined, landmarks };

  std::uint64_t number = 0, camera_frame = 0;
  Instant<CameraClock> stamp;
  Instant<GraphicsClock> image_time, arrived, drawn;
  Instant<PhysicsClock> asked;
  bool late = false;
  PoseSource pose_source = PoseSource::none;
  Pose<World, CameraOptical> X_world_camera;
  Matrix6 pose_covariance = Matrix6::Zero();  // rotation (rad, World axes), then translation (m)
  int landmarks_used = 0, landmarks_predicted = 0;
  double landmark_rms_px = 0.0;
  std::optional<double> expected_world_px;
};

struct RecordedClock {
  std::int64_t here_ns = 0, there_ns = 0;
  double drift_ppm = 0.0, uncertainty_s = 0.0;
};

std::string encode(const RecordedFrame& frame);  // palpate.recording.Frame
std::string encode(const RecordedClock& clock);  // palpate.recording.ClockModel
Expected<RecordedFrame> decode_frame(std::string_view bytes);

// A camera's place in World for viewers, as foxglove.FrameTransforms. `time`: log time, ns.
std::string encode_camera_place(const Pose<World, CameraOptical>& X_world_camera, std::uint64_t time,
                                const std::string& frame);

}  // namespace palpate::record::session
