#include "palpate/record/session/frame_messages.h"

#include <algorithm>
#include <cmath>

#include "palpate/record/session/internal/message_parts.h"
#include "palpate/record/session/internal/viewer_messages.h"

namespace palpate::record::session {

std::string encode(const RecordedFrame& frame) {
  recording::Frame out;
  out.set_number(frame.number);
  out.set_camera_frame(frame.camera_frame);
  out.set_stamp_ns(frame.stamp.ns());
  out.set_image_time_ns(frame.image_time.ns());
  out.set_arrived_ns(frame.arrived.ns());
  out.set_drawn_ns(frame.drawn.ns());
  out.set_asked_ns(frame.asked.ns());
  out.set_late(frame.late);
  out.set_pose_source(static_cast<recording::PoseSource>(static_cast<int>(frame.pose_source)));
  put_orientation(out.mutable_orientation_wxyz(), frame.X_world_camera.rotation);
  put(out.mutable_position_m(), frame.X_world_camera.translation);
  put_upper<6>(out.mutable_covariance(), frame.pose_covariance);
  out.set_landmarks_used(static_cast<std::uint32_t>(std::max(frame.landmarks_used, 0)));
  out.set_landmarks_predicted(static_cast<std::uint32_t>(std::max(frame.landmarks_predicted, 0)));
  out.set_landmark_rms_px(frame.landmark_rms_px);
  if (frame.expected_world_px) out.set_expected_world_px(*frame.expected_world_px);
  return out.SerializeAsString();
}

std::string encode(const RecordedClock& clock) {
  recording::ClockModel out;
  out.set_here_ns(clock.here_ns);
  out.set_there_ns(clock.there_ns);
  out.set_drift_ppm(clock.drift_ppm);
  out.set_uncertainty_s(clock.uncertainty_s);
  return out.SerializeAsString();
}

Expected<RecordedFrame> decode_frame(std::string_view bytes) {
  const auto in = parse<recording::Frame>(bytes, "a Frame");
  if (!in) return tl::unexpected(in.error());
  RecordedFrame frame;
  frame.number = in->number();
  frame.camera_frame = in->camera_frame();
  frame.stamp = {Duration(in->stamp_ns())};
  frame.image_time = {Duration(in->image_time_ns())};
  frame.arrived = {Duration(in->arrived_ns())};
  frame.drawn = {Duration(in->drawn_ns())};
  frame.asked = {Duration(in->asked_ns())};
  frame.late = in->late();
  if (!recording::PoseSource_IsValid(in->pose_source()))
    return refused("a Frame's pose has a source that means nothing here");
  frame.pose_source = static_cast<RecordedFrame::PoseSource>(in->pose_source());
  const auto rotation = orientation_of(in->orientation_wxyz());
  if (!rotation) return refused("a Frame has an orientation that is none");
  frame.X_world_camera.rotation = *rotation;
  frame.X_world_camera.translation = vector_of(in->position_m());
  if (!frame.X_world_camera.translation.allFinite() ||
      !read_upper<6>(in->covariance(), frame.pose_covariance))
    return refused("a Frame has no position, or no covariance of 21 numbers");
  constexpr std::uint32_t kMost = 1'000'000;
  frame.landmarks_used = static_cast<int>(std::min(in->landmarks_used(), kMost));
  frame.landmarks_predicted = static_cast<int>(std::min(in->landmarks_predicted(), kMost));
  frame.landmark_rms_px = in->landmark_rms_px();
  if (in->has_expected_world_px()) frame.expected_world_px = in->expected_world_px();
  return frame;
}

std::string encode_camera_place(const Pose<World, CameraOptical>& X_world_camera, std::uint64_t time,
                                const std::string& frame) {
  foxglove::FrameTransforms frames;
  add_frame(frames, time, "World", frame, X_world_camera.translation, X_world_camera.rotation);
  return frames.SerializeAsString();
}

}  // namespace palpate::record::session
