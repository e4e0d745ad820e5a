#include "palpate/calibration/session/procedures.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate::calibration::session {
namespace {

constexpr double kStillBefore = 0.03;  // s a pose has been still before a frame counts
constexpr double kFrameWait = 0.25;    // s to wait for a frame that shows the marker
constexpr double kSlipped = 0.03;      // m: the arm has lost the tip it should hold

std::vector<TrackedPose> evenly(const std::vector<TrackedPose>& all, int wanted) {
  if (static_cast<int>(all.size()) <= wanted) return all;
  std::vector<TrackedPose> some;
  some.reserve(static_cast<std::size_t>(wanted));
  for (int i = 0; i < wanted; ++i)
    some.push_back(all[static_cast<std::size_t>(i) * all.size() / static_cast<std::size_t>(wanted)]);
  return some;
}

Expected<void> begin(AcquisitionContext context, Recorder& recorder, const device::Request& request,
                     const char* what) {
  if (const auto asked = context.person.ask(request); !asked) return asked;
  auto ready = recorder.run_until_ready();
  if (!ready && ready.error().code == ErrorCode::timed_out)
    return refused(ErrorCode::timed_out, "{}: {}", what, ready.error().message);
  return ready;
}

// Too few of the frames showed the marker.
tl::unexpected<Error> not_seen(const char* what, std::size_t seen, int wanted) {
  return refused(
      "{}: the tracker saw the marker {} times where {} are wanted; turn it towards the tracker, uncover its "
      "LEDs, and record again",
      what, seen, wanted);
}

double tracker_frames_per_second(const Recorder& recorder, device::MarkerId marker, double seconds_long) {
  return static_cast<double>(recorder.poses(marker).size() +
                             static_cast<std::size_t>(recorder.missed(marker))) /
         seconds_long;
}

}  // namespace

Expected<std::vector<TrackedPose>> record_pivot(AcquisitionContext context,
                                                const PivotRecordingOptions& options) {
  Recorder recorder(context);
  recorder.tick();
  const std::string where = context.computed_arm ? "" : "hollow";
  if (const auto begun = begin(context, recorder, {device::Gesture::swing_stylus, where, 0}, "pivot"); !begun)
    return tl::unexpected(begun.error());
  Fixation fixation(options.fixation, recorder.newest_arm());
  bool slipped = false;
  recorder.set_control([&](const device::ArmSample& sample) {
    const Vector3 force = fixation.force(sample);
    slipped = slipped || fixation.displacement() > kSlipped;
    // Nothing limits this force: a real arm gives none, and its tip stands in a hollow.
    if (context.computed_arm) context.arm.command(slipped ? Vector3::Zero() : force);
  });
  if (options.holding) options.holding();
  recorder.run(1.0);  // the swing begins
  recorder.clear();
  double recorded = 0.0;
  const double longest = std::max(3.0 * options.seconds, options.poses / 20.0);
  std::vector<TrackedPose> poses;
  // At least the stated time, so that the swing is wide; longer where the poses are still too few.
  while (!slipped && recorded < longest && !context.stopped()) {
    recorder.run(std::min(1.0, options.seconds));
    recorded += std::min(1.0, options.seconds);
    if (recorded < options.seconds - 1e-9) continue;
    poses = recorder.poses(device::MarkerId::tip_marker);
    if (static_cast<int>(poses.size()) >= options.poses) break;
    // Nobody sees a hidden marker by waiting.
    if (tracker_frames_per_second(recorder, device::MarkerId::tip_marker, recorded) * longest <
            options.poses ||
        poses.empty())
      break;
  }
  if (context.computed_arm) context.arm.command(Vector3::Zero());
  if (const auto done = context.person.release(); !done) return tl::unexpected(done.error());
  if (slipped)
    return refused("pivot: the tip moved more than {:.0f} mm although {}; pull less", kSlipped * 1e3,
                   context.computed_arm ? "the arm held it" : "it stood in a hollow");
  if (static_cast<int>(poses.size()) < options.poses) return not_seen("pivot", poses.size(), options.poses);
  return evenly(poses, options.poses);
}

Expected<std::vector<TrackedPose>> record_pointer_pivot(AcquisitionContext context, int poses,
                                                        double seconds_long) {
  Recorder recorder(context);
  recorder.tick();
  if (const auto begun = begin(context, recorder, {device::Gesture::swing_pointer, "", 0}, "pointer pivot");
      !begun)
    return tl::unexpected(begun.error());
  recorder.clear();
  recorder.run(seconds_long);
  const auto seen = recorder.poses(device::MarkerId::pointer);
  if (static_cast<int>(seen.size()) < poses) return not_seen("pointer pivot", seen.size(), poses);
  return evenly(seen, poses);
}

Expected<std::vector<TrackedPose>> record_arm(AcquisitionContext context, int points) {
  ArmRecordingOptions options;
  options.points = points;
  return record_arm(context, options);
}

Expected<std::vector<TrackedPose>> record_arm(AcquisitionContext context,
                                              const ArmRecordingOptions& options) {
  const int points = options.points;
  Recorder recorder(context);
  recorder.tick();
  std::vector<TrackedPose> result;
  const int attempts = 3 * points + 10;
  for (int attempt = 0; attempt < attempts && static_cast<int>(result.size()) < points; ++attempt) {
    device::Request request{device::Gesture::next_pose, "", 0};
    if (options.next) request.target = options.next(result);
    const auto begun = begin(context, recorder, request, "arm pose");
    // Out of reach after all: another one is asked for.
    if (!begun && begun.error().code == ErrorCode::out_of_reach) continue;
    if (!begun) return tl::unexpected(begun.error());
    recorder.clear();
    const double still_since = recorder.now_s();
    std::optional<TrackedPose> frame;
    while (!frame && recorder.now_s() < still_since + kFrameWait && !context.stopped()) {
      recorder.run(0.005);
      for (const auto& sample : recorder.tracker_samples())
        if (sample.seen && sample.marker == device::MarkerId::tip_marker &&
            recorder.host_time(sample.stamp) > still_since + kStillBefore) {
          const auto poses = recorder.poses(device::MarkerId::tip_marker);
          if (!poses.empty() && poses.back().marker.stamp == sample.stamp) frame = poses.back();
        }
    }
    if (frame) {
      result.push_back(*frame);
      if (options.kept) options.kept(result);
    }
    if (attempt == 20 && result.empty()) break;  // hidden altogether
  }
  if (const auto done = context.person.release(); !done) return tl::unexpected(done.error());
  if (static_cast<int>(result.size()) < points) return not_seen("arm poses", result.size(), points);
  return result;
}

Expected<MovingRecord> record_moving(AcquisitionContext context, double seconds_long) {
  Recorder recorder(context);
  recorder.tick();
  if (const auto begun = begin(context, recorder, {device::Gesture::wander, "", 0}, "free motion"); !begun)
    return tl::unexpected(begun.error());
  recorder.clear();
  recorder.run(seconds_long);
  if (const auto done = context.person.release(); !done) return tl::unexpected(done.error());
  MovingRecord record{recorder.arm_readings(), recorder.poses(device::MarkerId::tip_marker)};
  constexpr int kFewest = 20;
  if (static_cast<int>(record.marker.size()) < kFewest)
    return not_seen("free motion", record.marker.size(), kFewest);
  return record;
}

double delay_sd_of_systematic(const MovingRecord& moving, const std::vector<TimedPoint>& places,
                              double lever) {
  double variance = 0.0;  // per axis
  for (const auto& pose : moving.marker) variance += pose.marker.systematic.trace() / 3.0;
  if (moving.marker.empty()) return 0.0;
  const double shift = std::sqrt(variance / static_cast<double>(moving.marker.size()));
  return delay_of_systematic(places, std::hypot(shift, shift / kSystematicReach * lever));
}

Expected<Vector3> record_rest(AcquisitionContext context) {
  Recorder recorder(context);
  recorder.tick();
  if (const auto begun = begin(context, recorder, {device::Gesture::rest, "", 0}, "rest"); !begun)
    return tl::unexpected(begun.error());
  recorder.run(0.2);
  recorder.clear();
  recorder.run(0.2);
  Vector3 sum = Vector3::Zero();
  const auto readings = recorder.arm_readings();
  if (readings.empty()) return refused("rest: the arm gave no readings; see that it is connected");
  for (const auto& reading : readings) sum += reading.joints;
  return Vector3(sum / static_cast<double>(readings.size()));
}

Expected<ViewRecord> record_views(AcquisitionContext context, device::Gesture gesture, double seconds_long,
                                  int every, const KeepImage& keep) {
  if (every < 1) throw std::invalid_argument("views: one image in `every` must be kept, at least 1");
  if (context.camera == nullptr) return refused("views: no camera; add one to the rig");
  Recorder recorder(context);
  recorder.tick();
  if (const auto begun = begin(context, recorder, {gesture, "", 0}, "views"); !begun)
    return tl::unexpected(begun.error());
  recorder.clear();
  context.camera->poll_unseen();  // pictures from before
  ClockEstimator<CameraClock, PhysicsClock> camera_clock;
  std::vector<Instant<CameraClock>> kept;
  int arrived = 0;
  const double end = recorder.now_s() + seconds_long;
  auto looked = context.clock.now();
  while (recorder.now_s() < end && !context.stopped()) {
    recorder.tick();
    const bool wanted = arrived % every == 0;
    const auto image = wanted ? context.camera->poll() : context.camera->poll_unseen();
    const auto before = std::exchange(looked, context.clock.now());
    if (!image) continue;
    ++arrived;
    camera_clock.add(image->mid_exposure, looked - image->waited, looked - before);
    if (wanted && keep(*image)) kept.push_back(image->mid_exposure);
  }
  ViewRecord record;
  record.tracked = recorder.poses(device::MarkerId::camera_marker);
  for (const auto& pose : record.tracked)
    record.hand.push_back({pose.time_s, {pose.marker.rotation, pose.marker.translation}});
  const auto model = camera_clock.model();
  for (const auto& stamp : kept) record.image_times_s.push_back(model.to(stamp).seconds());
  constexpr int kFewest = 10;
  if (static_cast<int>(record.hand.size()) < kFewest) return not_seen("views", record.hand.size(), kFewest);
  return record;
}

Expected<HandEyeRecord> record_hand_eye(AcquisitionContext context, double seconds_long,
                                        const SeeBoard& see) {
  std::vector<Pose<Board, CameraOptical>> seen;
  auto views = record_views(context, device::Gesture::look_around_board, seconds_long, 1,
                            [&](const device::CameraImage& image) {
                              const auto pose = see(image);
                              if (pose) seen.push_back(*pose);
                              return pose.has_value();
                            });
  if (!views) return tl::unexpected(views.error());
  HandEyeRecord record;
  record.hand = std::move(views->hand);
  for (std::size_t i = 0; i < seen.size(); ++i) record.eye.push_back({views->image_times_s[i], seen[i]});
  constexpr int kFewest = 10;
  if (static_cast<int>(record.eye.size()) < kFewest)
    return refused(
        "hand-eye: the camera saw the board {} times where {} are wanted; keep the whole board in view",
        record.eye.size(), kFewest);
  return record;
}

MeanTip mean_tip(const std::vector<TrackedPose>& frames, const Vector3& tip) {
  MeanTip mean;
  const double n = static_cast<double>(frames.size());
  for (const auto& frame : frames) {
    mean.place += (frame.marker.rotation * tip + frame.marker.translation) / n;
    const Matrix3& systematic = frame.marker.systematic;  // the same in all frames
    mean.covariance += (frame.marker.point_covariance(tip) - systematic) / (n * n) + systematic / n;
  }
  return mean;
}

std::vector<device::Request> corner_requests(const std::string& surface) {
  std::vector<device::Request> requests;
  for (int i = 0; i < 4; ++i) requests.push_back({device::Gesture::touch, surface, i});
  return requests;
}

Expected<std::vector<TouchedPoint>> record_touches(AcquisitionContext context,
                                                   const std::vector<device::Request>& places,
                                                   const Vector3& tip) {
  constexpr int kFrames = 20;
  Recorder recorder(context);
  recorder.tick();
  std::vector<TouchedPoint> touches;
  for (const auto& place : places) {
    if (const auto begun = begin(context, recorder, place, "touch"); !begun)
      return tl::unexpected(begun.error());
    recorder.clear();
    std::vector<TrackedPose> frames;
    const double still_since = recorder.now_s();
    while (static_cast<int>(frames.size()) < kFrames && recorder.now_s() < still_since + 1.0 &&
           !context.stopped()) {
      recorder.run(0.02);
      frames.clear();
      for (const auto& pose : recorder.poses(device::MarkerId::pointer))
        if (pose.time_s > still_since + kStillBefore) frames.push_back(pose);
    }
    if (static_cast<int>(frames.size()) < kFrames)
      return not_seen(("touch of " + place.what + " " + std::to_string(place.index + 1)).c_str(),
                      frames.size(), kFrames);
    TouchedPoint touch{place.what, place.index};
    const MeanTip mean = mean_tip(frames, tip);
    touch.place = mean.place;
    touch.covariance = mean.covariance;
    touch.X_world_pointer.rotation = frames.back().marker.rotation;
    touch.X_world_pointer.translation = touch.place - touch.X_world_pointer.rotation * tip;
    touches.push_back(touch);
  }
  return touches;
}

}  // namespace palpate::calibration::session
