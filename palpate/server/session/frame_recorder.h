// Writes what a graphics server knows and does into a recording: each frame, the clocks beside its own, what is wrong with its
// devices, and for viewers where the camera is and how it sees. What its devices measure they write themselves
// (record/session/recorded_drivers.h). The thread that draws; the recording must outlive it.
#pragma once

#include <optional>

#include "palpate/record/session/session_recording.h"
#include "palpate/rig/rig.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/time/clock.h"

namespace palpate::server::session {

class FrameRecorder {
 public:
  // The rig becomes an attachment: `rig_text`, or where that is empty a text made of it.
  FrameRecorder(record::session::SessionRecording& recording, const rig::Rig& rig,
                const std::string& rig_text, const MonotonicClock<GraphicsClock>& clock);

  void write(const graphics::FrameRecord& frame, const graphics::GraphicsServer& server);
  // Conditions that have begun or ended since the last call.
  void write(const std::vector<graphics::Condition>& conditions, Instant<GraphicsClock> now);

 private:
  std::uint64_t log_time(Instant<GraphicsClock> t) const {
    return recording_.log_time(clock_.to_monotonic(t));
  }
  void write_calibration(Instant<GraphicsClock> now);

  record::session::SessionRecording& recording_;
  const MonotonicClock<GraphicsClock>& clock_;
  std::optional<device::CameraModel> camera_;
  record::RecordStream &frame_, &physics_clock_, &condition_, &tf_, &calibration_;
  std::vector<graphics::Condition> told_;
  std::optional<Instant<GraphicsClock>> calibration_written_;
};

}  // namespace palpate::server::session
