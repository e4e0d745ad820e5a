#include "palpate/server/session/frame_recorder.h"

#include <algorithm>

#include "palpate/core/log.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/frame_messages.h"

namespace palpate::server::session {
namespace {

constexpr Log kRecordingLog("recording");
constexpr const char* kLeftCamera = "camera_left";

record::session::RecordedFrame recorded(const graphics::FrameRecord& frame) {
  record::session::RecordedFrame r;
  r.number = frame.number;
  r.camera_frame = frame.camera_frame;
  r.stamp = frame.stamp;
  r.image_time = frame.image_time;
  r.arrived = frame.arrived;
  r.drawn = frame.drawn;
  r.asked = frame.asked;
  r.late = frame.late;
  r.pose_source = static_cast<record::session::RecordedFrame::PoseSource>(frame.pose_source);
  r.X_world_camera = frame.X_world_camera;
  r.pose_covariance = frame.pose_covariance;
  r.landmarks_used = frame.landmarks_used;
  r.landmarks_predicted = frame.landmarks_predicted;
  r.landmark_rms_px = frame.landmark_rms_px;
  r.expected_world_px = frame.expected_world_px;
  return r;
}

}  // namespace

FrameRecorder::FrameRecorder(record::session::SessionRecording& recording, const rig::Rig& rig,
                             const std::string& rig_text, const MonotonicClock<GraphicsClock>& clock)
    : recording_(recording),
      clock_(clock),
      frame_(recording.stream("/frame", "palpate.recording.Frame")),
      physics_clock_(recording.stream("/clock/physics", "palpate.recording.ClockModel")),
      condition_(recording.stream("/condition", "palpate.recording.Condition")),
      tf_(recording.stream("/tf", "foxglove.FrameTransforms")),
      calibration_(recording.stream("/camera/left/calibration", "foxglove.CameraCalibration")) {
  if (rig.camera) camera_ = rig.camera->model;
  if (auto done =
          recording.attach("rig.toml", "application/toml", rig_text.empty() ? rig::rig_text(rig) : rig_text);
      !done)
    kRecordingLog.warning("warning: {}", done.error().message);
}

void FrameRecorder::write(const graphics::FrameRecord& frame, const graphics::GraphicsServer& server) {
  const auto time = log_time(frame.drawn);
  frame_.write(time, time, record::session::encode(recorded(frame)));
  tf_.write(time, time, record::session::encode_camera_place(frame.X_world_camera, time, kLeftCamera));
  if (server.sync().exchanges() > 0) {
    const auto& model = server.sync().model();
    const record::session::RecordedClock clock{.here_ns = frame.drawn.ns(),
                                               .there_ns = model.to(frame.drawn).ns(),
                                               .drift_ppm = model.drift_ppm(),
                                               .uncertainty_s = to_seconds(model.uncertainty(frame.drawn))};
    physics_clock_.write(time, time, record::session::encode(clock));
  }
  write_calibration(frame.drawn);
}

void FrameRecorder::write(const std::vector<graphics::Condition>& conditions, Instant<GraphicsClock> now) {
  const auto has = [](const auto& list, device::HealthCode code) {
    return std::any_of(list.begin(), list.end(), [&](const auto& c) { return c.code == code; });
  };
  const auto time = log_time(now);
  for (const auto& condition : told_)
    if (!has(conditions, condition.code))
      condition_.write(time, time, record::session::encode_condition(condition.code, false, condition.words));
  for (const auto& condition : conditions)
    if (!has(told_, condition.code))
      condition_.write(time, time, record::session::encode_condition(condition.code, true, condition.words));
  told_ = conditions;
}

// Again each second: who begins to look in the middle has missed the first.
void FrameRecorder::write_calibration(Instant<GraphicsClock> now) {
  if (!camera_ || (calibration_written_ && now - *calibration_written_ < std::chrono::seconds(1))) return;
  calibration_written_ = now;
  const auto time = log_time(now);
  calibration_.write(time, time, record::session::encode_calibration(*camera_, time, kLeftCamera));
}

}  // namespace palpate::server::session
