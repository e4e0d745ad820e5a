#include "palpate/graphics_server/graphics_server.h"

#include <stdexcept>
#include <utility>

namespace palpate {

GraphicsServer::GraphicsServer(Rig rig, StateLink& link, TrackerDevice& tracker, CameraDevice& camera,
                               PoseRefiner refiner, FramePainter painter)
    : rig_(std::move(rig)),
      link_(link),
      tracker_(tracker),
      camera_(camera),
      refiner_(std::move(refiner)),
      painter_(std::move(painter)) {
  if (!rig_.camera) throw std::invalid_argument("graphics server: the rig has no camera calibration");
  if (!rig_.hand_eye) throw std::invalid_argument("graphics server: the rig has no hand-eye calibration");
}

void GraphicsServer::service(Instant<GraphicsClock> now) {
  const Duration waited = now - last_look_.value_or(now);
  last_look_ = now;
  for (const auto& sample : tracker_.poll()) {
    tracker_clock_.add(sample.stamp, now, waited);
    if (!sample.seen) continue;
    const MarkerPose pose{tracker_clock_.model().to(sample.stamp), sample.rotation, sample.translation,
                          sample.covariance};
    if (sample.marker == MarkerId::camera_marker) camera_marker_.add(pose);
    if (tap_) tap_(sample.marker, pose);
  }

  link_.poll();
  for (const auto& arrived : link_.arrived()) {
    round_trips_.push_back(to_seconds(arrived.received - arrived.sent));
    // A server that has no state yet answers with an empty one: nothing to draw.
    if (arrived.newest && arrived.reply.answer.state.tick > 0) last_answer_ = arrived.reply.answer;
  }
  while (const auto stamps = link_.take_sync()) sync_.add(stamps->t1, stamps->t2, stamps->t3, stamps->t4);
  if (!last_sync_sent_ || now - *last_sync_sent_ >= sync_.interval()) {
    if (link_.send_sync()) last_sync_sent_ = now;
  }

  if (auto image = camera_.poll()) {
    camera_clock_.add(image->mid_exposure, now, waited);
    arrived_image_ = std::move(image);  // the newest wins: an older one that nobody took up is dropped
  }
}

bool GraphicsServer::begin_frame(Instant<GraphicsClock> now) {
  if (!arrived_image_) return false;
  image_ = std::move(arrived_image_);
  arrived_image_.reset();
  record_ = FrameRecord{
      .number = ++frames_, .camera_frame = image_->frame, .stamp = image_->mid_exposure, .begun = now};
  const DelayCalibration delays = rig_.delays.value_or(DelayCalibration{});
  record_.image_time =
      camera_clock_.model().to(image_->mid_exposure) - seconds(delays.camera_after_tracker_s);
  if (sync_.exchanges() > 0) {
    record_.asked = sync_.remote_time(record_.image_time) - seconds(delays.tracker_after_arm_s);
    const bool shape = link_.description() && link_.description()->shape_vertices > 0;
    record_.requested = link_.request(record_.number, record_.asked, shape);
  }
  estimate_pose(record_);
  return true;
}

const FrameRecord& GraphicsServer::finish_frame(Instant<GraphicsClock> now) {
  service(now);
  const auto& newest = link_.newest();
  record_.late = !newest || newest->reply.number != record_.number;
  if (last_answer_) {
    record_.have_state = true;
    record_.state = last_answer_->state;
    record_.answer = last_answer_->kind;
    record_.extrapolated_by = last_answer_->extrapolated_by;
  }
  if (record_.requested) link_.frame_drawn(record_.number);
  if (painter_ && image_) painter_(*image_, record_);
  record_.drawn = now;
  image_.reset();
  return record_;
}

void GraphicsServer::estimate_pose(FrameRecord& record) {
  const auto marker = camera_marker_.at(record.image_time);
  if (!marker) {
    // The marker was hidden from the tracker when the image was taken: the last pose is the best there is to
    // draw with, and the record says that nothing was known.
    record.X_world_camera = last_pose_;
    return;
  }
  const Pose<World, CameraMarker> X_world_marker{marker->rotation, marker->translation};
  record.X_world_camera_tracker = X_world_marker * rig_.hand_eye->X_marker_camera;
  record.X_world_camera = record.X_world_camera_tracker;
  record.pose_source = PoseSource::tracker;
  if (refiner_) {
    // The marker's covariance carried along the lever to the camera: a turn w of the marker moves the camera
    // by w x lever.
    const Vector3 lever = record.X_world_camera.translation - marker->translation;
    Matrix6 J = Matrix6::Identity();
    J.bottomLeftCorner<3, 3>() = -hat(lever);
    refiner_(*image_, J * marker->covariance * J.transpose(), record);
  }
  last_pose_ = record.X_world_camera;
}

std::vector<double> GraphicsServer::take_round_trips() { return std::exchange(round_trips_, {}); }

}  // namespace palpate
