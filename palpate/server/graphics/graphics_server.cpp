#include "palpate/server/graphics/graphics_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "palpate/scene/scene_comparison.h"

namespace palpate::server::graphics {
namespace {

constexpr Duration kMostExtraDelay = std::chrono::seconds(1);

// While the tracker is blind the head moves on as it did between the last two pictures, for so long; it turns
// and shifts otherwise by about this much within a frame (a head that shakes by half a degree six times a
// second).
constexpr Duration kPoseCarried = std::chrono::milliseconds(150);
constexpr double kTurnDoubt = 0.01, kShiftDoubt = 0.005;  // rad, m

// A picture is seen less than this after its state: delays of a second at most, and drawing. An older state, of a
// server that has gone or whose clock is another, is not reckoned on for hours.
constexpr Duration kFurthestAhead = std::chrono::seconds(3);

// A predicted picture: how much the hand speeds up is seen over the first; not beyond the second does that say where it
// will be.
constexpr Duration kHandBefore = std::chrono::milliseconds(8), kHandAhead = std::chrono::milliseconds(60);
constexpr double kMostHandGains = 1000.0;  // m/s^2; no hand does, another server's numbers may

// The last two poses carried on to `time`.
template <typename D>
Pose<World, CameraOptical> carried_on(const D& a, const D& b, Instant<GraphicsClock> time) {
  const double share = to_seconds(time - b.time) / to_seconds(b.time - a.time);
  const Vector3 turn = so3_log(b.X_world_camera.rotation * a.X_world_camera.rotation.conjugate());
  return {
      (so3_exp(share * turn) * b.X_world_camera.rotation).normalized(),
      b.X_world_camera.translation + share * (b.X_world_camera.translation - a.X_world_camera.translation)};
}

// The question's number where a frame asks for the state a little before its own; the check of predictions has its own.
constexpr std::uint64_t kBefore = std::uint64_t{1} << 62;
std::uint64_t before_question(std::uint64_t frame) { return kBefore | frame; }

// A pose's covariance for another place on the same body: a turn w moves what is a lever away by w x lever.
Matrix6 carried_along(const Vector3& lever, const Matrix6& covariance) {
  Matrix6 J = Matrix6::Identity();
  J.bottomLeftCorner<3, 3>() = -hat(lever);
  return J * covariance * J.transpose();
}

}  // namespace

GraphicsServer::GraphicsServer(rig::Rig rig, transport::StateLink& link, device::TrackerDevice& tracker,
                               device::CameraDevice& camera, FramePipeline& pipeline,
                               const GraphicsSettings& settings)
    : rig_(std::move(rig)),
      link_(link),
      tracker_(tracker),
      camera_(camera),
      pipeline_(pipeline),
      settings_(settings),
      watch_(rig_.camera ? rig_.camera->model.width : 0, rig_.camera ? rig_.camera->model.height : 0) {
  if (!rig_.camera) throw std::invalid_argument("graphics server: the rig has no camera calibration");
  if (!rig_.hand_eye && !rig_.board)
    throw std::invalid_argument("graphics server: the rig has no hand-eye calibration");
  if (rig_.board && settings.picture_time == PictureTime::predicted)
    throw std::invalid_argument("graphics server: a rig with a board shows registered pictures only");
  if (rig_.board) watch_.set_on_board();
  if (settings.extra_delay < Duration(0) || settings.extra_delay > kMostExtraDelay)
    throw std::invalid_argument("graphics server: the extra picture delay must lie in 0 ... 1 s");
  if (settings.scan_out < Duration(0) || settings.scan_out > kMostExtraDelay)
    throw std::invalid_argument("graphics server: the display's scan-out must lie in 0 ... 1 s");
}

void GraphicsServer::add_right_camera(device::CameraDevice& right, bool one_clock) {
  if (!rig::has_two_eyes(rig_))
    throw std::invalid_argument("graphics server: the rig's right camera is not calibrated");
  if (rig_.board) throw std::invalid_argument("graphics server: a rig with a board has one camera");
  if (rig_.right_camera->model.width != rig_.camera->model.width ||
      rig_.right_camera->model.height != rig_.camera->model.height)
    throw std::invalid_argument("graphics server: the two cameras' images must have one size");
  right_camera_ = &right;
  one_clock_ = one_clock;
}

void GraphicsServer::take_image(device::CameraImage image, Instant<GraphicsClock> now, Duration waited) {
  if (!watch_.image(now, image.width, image.height)) return;  // nothing that could be drawn
  // An image whose stamp is doubted is taken for one that arrived in time: that is what its stamp would say.
  const auto time =
      camera_clock_.take(image.mid_exposure, now - image.waited, waited).value_or(now - image.waited);
  if (camera_clock_.found_set()) watch_.camera_clock_set(now);
  const Duration stamp = image.mid_exposure.since_epoch;
  StereoPair::Timed timed{std::move(image), now, time, one_clock_ ? stamp : time.since_epoch};
  if (right_camera_ != nullptr)
    pair_.left(std::move(timed));
  else
    arrive({std::move(timed), std::nullopt});
}

void GraphicsServer::take_right_image(device::CameraImage image, Instant<GraphicsClock> now,
                                      Duration waited) {
  if (!watch_.right_image(image.width, image.height)) return;
  const Duration stamp = image.mid_exposure.since_epoch;
  const auto time = right_camera_clock_.take(image.mid_exposure, now - image.waited, waited);
  if (one_clock_ || time)
    pair_.right({std::move(image), now, time.value_or(now), one_clock_ ? stamp : time->since_epoch});
}

void GraphicsServer::arrive(Arrived images) {
  if (settings_.extra_delay == Duration(0) && !arrived_.empty()) {
    give_back(std::move(arrived_.front()));  // an older one that nobody took up is dropped
    arrived_.clear();
  }
  arrived_.push_back(std::move(images));
}

void GraphicsServer::service(Instant<GraphicsClock> now) {
  const Duration waited = now - last_look_.value_or(now);
  last_look_ = now;
  // How long they have waited is counted until they were asked for: each is followed by a look at the clock, which may be
  // late but never early.
  const auto asked = [&] { return clock_ != nullptr ? clock_->now() : now; };
  auto image = camera_.poll();
  const auto image_asked = asked();
  auto right_image = right_camera_ != nullptr ? right_camera_->poll() : std::nullopt;
  const auto right_asked = asked();
  const auto tracked = tracker_.poll();
  const auto tracker_asked = asked();
  for (const auto& sample : tracked) {
    const auto time = tracker_clock_.take(sample.stamp, tracker_asked - sample.waited, waited);
    if (tracker_clock_.found_set()) watch_.tracker_clock_set(now);
    watch_.tracker_sample(now, sample.marker == device::MarkerId::camera_marker, sample.seen);
    if (!sample.seen || !time) continue;
    const device::MarkerPose pose{*time, sample.rotation, sample.translation, sample.covariance};
    if (sample.marker == device::MarkerId::camera_marker) camera_marker_.add(pose);
    if (tap_) tap_(sample.marker, pose);
  }

  take_states(now);
  while (const auto stamps = link_.take_sync()) sync_.add(stamps->t1, stamps->t2, stamps->t3, stamps->t4);
  if (!last_sync_sent_ || now - *last_sync_sent_ >= sync_.interval()) {
    if (link_.send_sync()) last_sync_sent_ = now;
  }

  if (predicts() && link_.description())
    predictions_.service(now, sync_.model(), tracker_after_arm(), camera_marker_, *link_.description());

  if (image) take_image(std::move(*image), image_asked, waited);
  if (right_camera_ != nullptr) {
    if (right_image) take_right_image(std::move(*right_image), right_asked, waited);
    if (auto images = pair_.take(now)) arrive(std::move(*images));
    watch_.right_eye(now, !pair_.right_lost());
  }
  watch_.look(now);
}

void GraphicsServer::take_states(Instant<GraphicsClock> now) {
  link_.poll();
  for (const auto& arrived : link_.arrived()) {
    round_trips_.push_back(to_seconds(arrived.received - arrived.sent));
    // A server that has no state yet answers with an empty one: nothing to draw.
    if (arrived.newest && !arrived.reply.answer.state.empty()) last_answer_ = arrived.reply.answer;
  }
  for (const auto& before : link_.looked_back())
    if (before.number == before_question(record_.number)) state_before_ = before.answer.state;
  if (drawn_ && link_.description() && met_ != link_.descriptions()) meet(*link_.description(), now);
}

// Whatever came together with the description may be of the server before.
void GraphicsServer::meet(const scene::SceneDescription& played, Instant<GraphicsClock> now) {
  met_ = link_.descriptions();
  const auto other = scene::other_than_drawn(*drawn_, played);
  if (other_scene_ || other) last_answer_.reset(), state_before_.reset();
  other_scene_ = other.has_value();
  const auto places = scene::compare_rigs(*drawn_, played);
  std::optional<std::string> scene_words, rig_words;
  if (other)
    scene_words = fmt::format("the physics server now plays {}; start `palpate graphics` again", *other);
  if (!places.agree())
    rig_words = fmt::format("the physics server has another rig: {}; both servers need the same rig file",
                            places.words());
  watch_.scene_described(now, std::move(scene_words), std::move(rig_words));
}

bool GraphicsServer::image_waits(Instant<GraphicsClock> now) const {
  return !arrived_.empty() && now - arrived_.front().left.at >= settings_.extra_delay;
}

bool GraphicsServer::begin_frame(Instant<GraphicsClock> now) {
  if (!image_waits(now)) return false;
  while (!arrived_.empty() && now - arrived_.front().left.at >= settings_.extra_delay) {
    if (image_) give_back(std::move(*image_));
    image_ = std::move(arrived_.front());
    arrived_.pop_front();
  }
  // The picture's memory is the next one's.
  auto pixels = std::exchange(record_.rgb, {});
  pixels.clear();
  record_ = {};
  record_.rgb = std::move(pixels);
  record_.number = ++frames_;
  record_.camera_frame = image_->left.image.frame;
  record_.stamp = image_->left.image.mid_exposure;
  record_.arrived = image_->left.at;
  record_.begun = now;
  record_.picture_time = settings_.picture_time;
  record_.two_eyes = right_camera_ != nullptr;
  const rig::DelayCalibration delays = rig_.delays.value_or(rig::DelayCalibration{});
  record_.image_time = image_->left.time - seconds(delays.camera_after_tracker_s);
  if (sync_.exchanges() > 0) {
    // A predicted picture starts from the newest state there is.
    record_.asked =
        predicts() ? sync_.remote_time(now) : sync_.remote_time(record_.image_time) - tracker_after_arm();
    const bool shape = link_.description() && link_.description()->shape_vertices > 0;
    record_.requested = link_.request(record_.number, record_.asked, shape);
    state_before_.reset();
    if (predicts()) link_.look_back(before_question(record_.number), record_.asked - kHandBefore);
  }
  estimate_pose(record_);
  return true;
}

const FrameRecord& GraphicsServer::finish_frame(Instant<GraphicsClock> now) {
  service(now);
  // Late latch: a tracker sample that had not come when the frame was begun.
  if (image_ && record_.pose_source == PoseSource::none && !rig_.board) estimate_pose(record_);
  const auto& newest = link_.newest();
  record_.late = !newest || newest->reply.number != record_.number;
  record_.other_scene = other_scene_;
  if (last_answer_ && !other_scene_) {
    record_.have_state = true;
    record_.state = last_answer_->state;
    record_.shape = link_.newest_shape();
    record_.answer = last_answer_->kind;
    record_.extrapolated_by = last_answer_->extrapolated_by;
  }
  record_.photon = expected_light(now);
  if (predicts()) predict(record_);
  if (record_.requested) link_.frame_drawn(record_.number);
  record_.conditions = conditions();
  if (image_) pipeline_.draw(image_->left.image, image_->right ? &*image_->right : nullptr, record_);
  record_.drawn = now;
  if (image_) {
    std::swap(finished_image_, image_->left.image);
    give_back(std::move(*image_));
    image_.reset();
  }
  return record_;
}

void GraphicsServer::give_back(Arrived images) {
  camera_.take_back(std::move(images.left.image));
  if (images.right) right_camera_->take_back(std::move(*images.right));
}

Instant<GraphicsClock> GraphicsServer::ready(Instant<GraphicsClock> at) {
  ready_ = at;
  if (display_time_) return at;
  const auto due = pace_.due(record_.image_time, at);
  return image_waits(at) ? at : due;
}

// Drawing takes as long as lately; a picture that is ready sooner than it is due is held.
Instant<GraphicsClock> GraphicsServer::expected_light(Instant<GraphicsClock> now) const {
  const auto ready = now + drawing_;
  if (display_time_ || !pace_.age()) return light_of(ready);
  return light_of(std::max(ready, record_.image_time + *pace_.age()));
}

void GraphicsServer::shown(Instant<GraphicsClock> at) {
  drawing_times_[frames_ % drawing_times_.size()] =
      std::exchange(ready_, std::nullopt).value_or(at) - record_.drawn;
  auto times = drawing_times_;
  const std::size_t count = std::min<std::size_t>(frames_, times.size());
  // Those not written yet stand at the end, longer than any.
  std::sort(times.begin(), times.end());
  drawing_ = times[(count - 1) / 2];
  if (!predicts() || record_.answer != AnswerKind::extrapolated || newest_state_.empty()) return;
  const auto light = light_of(at);
  predictions_.shown({.frame = &record_,
                      .newest = &newest_state_,
                      .marker = marker_ahead_,
                      .light = light,
                      .marker_light = light + tracker_after_arm(),
                      .image_time = record_.image_time});
}

Instant<GraphicsClock> GraphicsServer::light_of(Instant<GraphicsClock> presented) const {
  return display_time_ ? display_time_(presented) : presented + settings_.scan_out;
}

void GraphicsServer::estimate_pose(FrameRecord& record) {
  estimate_left(record);
  if (image_->right) estimate_right(record);
}

void GraphicsServer::estimate_left(FrameRecord& record) {
  if (rig_.board) return pose_from_image(record);
  const auto marker = camera_marker_.at(record.image_time);
  if (marker) {
    const Pose<World, CameraMarker> X_world_marker{marker->rotation, marker->translation};
    record.have_tracker = true;
    record.X_world_camera_tracker = X_world_marker * rig_.hand_eye->X_marker_camera;
    record.X_world_camera = record.X_world_camera_tracker;
    record.pose_source = PoseSource::tracker;
    Matrix6 covariance =
        carried_along(record.X_world_camera.translation - marker->translation, marker->covariance);
    // A head that moves, at a moment known to so much.
    if (last_ && before_last_ && last_->time > before_last_->time && rig_.delays &&
        rig_.delays->camera_known()) {
      const double uncertain = rig_.delays->camera_std_s / to_seconds(last_->time - before_last_->time);
      Vector6 by;
      by << so3_log(last_->X_world_camera.rotation * before_last_->X_world_camera.rotation.conjugate()),
          last_->X_world_camera.translation - before_last_->X_world_camera.translation;
      covariance += uncertain * uncertain * by * by.transpose();
    }
    record.pose_covariance = covariance;
    pipeline_.refine(EyeSide::left, image_->left.image, covariance, record);
  } else {
    pose_without_tracker(record);
  }
  if (pipeline_.sees())
    watch_.landmarks(
        record.begun, record.landmarks_predicted, record.landmarks_used,
        record.pose_source == PoseSource::refined || record.pose_source == PoseSource::landmarks);
  if (record.pose_source == PoseSource::none) return;
  if (!last_ || record.image_time > last_->time)
    before_last_ = std::exchange(last_, Drawn{record.image_time, record.X_world_camera});
}

// The head's marker was hidden from the tracker when the image was taken. The landmarks can still say where
// the camera is, if it is known about where to look for them; else the last pose is the best there is to draw
// with, and the record says that nothing was known.
void GraphicsServer::pose_without_tracker(FrameRecord& record) {
  if (!last_) return;
  record.X_world_camera = last_->X_world_camera;
  const Duration since = record.image_time - last_->time;
  if (!pipeline_.sees() || !before_last_ || since <= Duration(0) || since > kPoseCarried ||
      last_->time - before_last_->time > kPoseCarried)
    return;
  record.X_world_camera = carried_on(*before_last_, *last_, record.image_time);
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal() << Vector3::Constant(kTurnDoubt * kTurnDoubt),
      Vector3::Constant(kShiftDoubt * kShiftDoubt);
  record.pose_covariance = covariance;
  pipeline_.refine(EyeSide::left, image_->left.image, covariance, record);
  if (record.pose_source == PoseSource::refined)
    record.pose_source = PoseSource::landmarks;
  else
    record.X_world_camera = last_->X_world_camera;
}

// From the left eye's pose, as its picture has refined it, on: so the right one knows what both pictures say.
// How the two cameras stand to each other is as uncertain as the right one's hand-eye transform, which the
// refiner counts in; that of the left has gone into its picture.
void GraphicsServer::estimate_right(FrameRecord& record) const {
  EyePose& right = record.right.emplace();
  right.X_world_camera = rig::right_eye_pose(rig_, record.X_world_camera);
  right.pose_source = record.pose_source;
  right.have_tracker = record.have_tracker;
  if (record.have_tracker)
    right.X_world_camera_tracker = rig::right_eye_pose(rig_, record.X_world_camera_tracker);
  if (record.pose_source == PoseSource::none) return;
  const Matrix6 covariance = carried_along(
      right.X_world_camera.translation - record.X_world_camera.translation, record.pose_covariance);
  right.pose_covariance = covariance;
  pipeline_.refine(EyeSide::right, *image_->right, covariance, right);
  if (record.pose_source == PoseSource::landmarks && right.pose_source == PoseSource::refined)
    right.pose_source = PoseSource::landmarks;
}

void GraphicsServer::pose_from_image(FrameRecord& record) {
  std::optional<Pose<World, CameraOptical>> near;
  if (last_) {
    record.X_world_camera = last_->X_world_camera;
    const Duration since = record.image_time - last_->time;
    if (since > Duration(0) && since <= kPoseCarried) near = last_->X_world_camera;
  }
  const auto found = pipeline_.find(image_->left.image, near, record);
  watch_.board(record.begun, found.has_value(), found ? "" : found.error().message);
  if (!found) return;
  record.pose_source = PoseSource::landmarks;
  last_ = Drawn{record.image_time, record.X_world_camera};
}

void GraphicsServer::predict(FrameRecord& record) {
  marker_ahead_.reset();
  newest_state_ = record.have_state ? record.state : scene::SceneState{};
  if (!display_time_) predict_pose(record);
  predict_state(record);
}

// The image's own pose, moved on as the tracker saw the marker move from then until now, and on as it has sped up. The
// tracker's stamps show the world tracker_after_arm earlier than they say.
void GraphicsServer::predict_pose(FrameRecord& record) {
  const auto then = camera_marker_.at(record.image_time);
  const auto ahead = camera_marker_.predict(record.photon + tracker_after_arm(),
                                            device::MarkerHistory::Course::accelerating);
  if (!then || !ahead || record.pose_source == PoseSource::none) return;
  const Pose<World, CameraMarker> X_then{then->rotation, then->translation},
      X_ahead{ahead->rotation, ahead->translation};
  marker_ahead_ = X_ahead;
  // In the marker's axes: an error of the tracker's that stays drops out.
  const Pose<CameraMarker, CameraMarker> moved = X_then.inverse() * X_ahead;
  const Pose<World, CameraMarker> X_marker =
      record.X_world_camera * rig_.hand_eye->X_marker_camera.inverse() * moved;
  const Pose<World, CameraOptical> before = record.X_world_camera;
  record.X_world_camera = X_marker * rig_.hand_eye->X_marker_camera;
  record.pose_covariance += then->covariance + ahead->covariance;
  if (!record.right) return;
  record.right->X_world_camera = record.X_world_camera * (before.inverse() * record.right->X_world_camera);
  record.right->pose_covariance += then->covariance + ahead->covariance;
}

void GraphicsServer::predict_state(FrameRecord& record) const {
  if (!record.have_state || sync_.exchanges() == 0) return;
  const Duration ahead = std::min(sync_.model().to(record.photon) - record.state.time, kFurthestAhead);
  if (ahead <= Duration(0)) return;
  predict_hand(record.state, ahead);
  record.state = pipeline_.predict(record.state, ahead);
  record.answer = AnswerKind::extrapolated;
  record.extrapolated_by = ahead;
}

// What the stylus carries goes where the hand takes it, and a hand speeds up and slows down: its mean velocity over `ahead` is
// that of now and half of what it gains meanwhile. Application::predict carries bodies on by their velocities alone.
void GraphicsServer::predict_hand(scene::SceneState& state, Duration ahead) const {
  if (!state_before_ || ahead > kHandAhead || state.body_count <= static_cast<int>(scene::kCarried)) return;
  const double gone = to_seconds(state.time - state_before_->time);
  if (state_before_->empty() || gone < 0.5 * to_seconds(kHandBefore)) return;
  auto& hand = state.bodies[scene::kCarried];
  const auto& before = state_before_->bodies[scene::kCarried];
  if (hand.jumps != before.jumps || (hand.v() - before.v()).norm() > kMostHandGains * gone) return;
  const double share = 0.5 * to_seconds(ahead) / gone;
  hand.set_v(hand.v() + share * (hand.v() - before.v()));
  const Vector3 turning(hand.angular_velocity.data());
  hand.set_w(turning + share * (turning - Vector3(before.angular_velocity.data())));
}

bool GraphicsServer::answered() const {
  const auto& newest = link_.newest();
  return !record_.requested || (newest && newest->reply.number == record_.number);
}

std::vector<double> GraphicsServer::take_round_trips() { return std::exchange(round_trips_, {}); }

}  // namespace palpate::server::graphics
