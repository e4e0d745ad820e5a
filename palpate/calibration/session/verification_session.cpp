#include "palpate/calibration/session/verification_session.h"

#include <fmt/format.h>

#include <cmath>

#include "palpate/calibration/motion_delay.h"
#include "palpate/calibration/session/board_views.h"
#include "palpate/core/units.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/landmark_detector.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate::calibration::session {
namespace {

// Landmarks by which a picture tells more than where it was taken from.
constexpr std::size_t kFewestDots = 3;
constexpr std::size_t kArmEvery = 5;   // of its 1 kHz: the tracker is slower still
constexpr double kLongestDelay = 0.3;  // s
// Arm and marker hold one stylus: what the one does not explain of the other is some tenths of a millimetre in a decimetre. A
// delay at which they move less alike is none of a device: one of the streams was held up.
constexpr double kMoveAlike = 0.998;

// Looks near the places where the landmarks should be, and farther around once most of them are not there: a camera
// that was knocked shows them elsewhere, all by the same turn. Once a picture has shown most of them there is no more
// searching: in a poor picture another turn takes one dot for its neighbour.
class WideFinder {
 public:
  explicit WideFinder(FindLandmarks find) : find_(std::move(find)) {}

  std::vector<vision::Sighting> operator()(const device::CameraImage& image,
                                           const rig::CameraCalibration& camera,
                                           const Pose<World, CameraOptical>& X_world_camera,
                                           const std::vector<rig::Landmark>& landmarks) {
    auto found = find_(image, camera, turned(X_world_camera, turn_), landmarks);
    const auto expected =
        static_cast<std::size_t>(vision::predicted_landmarks(camera.model, X_world_camera, landmarks));
    settled_ = settled_ || 2 * found.size() >= expected;
    if (settled_ || searched_ >= kSearches) return found;
    ++searched_;
    for (int across = -kSteps; across <= kSteps; ++across)
      for (int up = -kSteps; up <= kSteps; ++up) {
        const Vector3 turn = kStep * Vector3(up, across, 0.0);
        auto there = find_(image, camera, turned(X_world_camera, turn), landmarks);
        if (there.size() <= found.size()) continue;
        found = std::move(there);
        turn_ = turn;
      }
    return found;
  }

 private:
  static constexpr int kSteps = 4, kSearches = 5;
  static constexpr double kStep = 0.0122;  // rad, 0.7 deg: some 7 px, within the detector's reach

  static Pose<World, CameraOptical> turned(Pose<World, CameraOptical> pose, const Vector3& turn) {
    pose.rotation = (pose.rotation * so3_exp(turn)).normalized();
    return pose;
  }

  FindLandmarks find_;
  Vector3 turn_ = Vector3::Zero();
  int searched_ = 0;
  bool settled_ = false;
};

struct Look {
  AcquisitionContext context;
  const rig::Rig& rig;
  const VerificationPlan& plan;
  const VerificationHooks& hooks;
  VerificationRecord& out;

  Expected<void> rest() {
    const auto readings = record_rest(context);
    if (!readings) return tl::unexpected(readings.error());
    out.observed.rest = device::JointVector(*readings);
    return {};
  }

  Expected<void> stylus() {
    const auto poses = record_arm(context, plan.poses);
    if (!poses) return tl::unexpected(poses.error());
    for (const auto& pose : *poses)
      out.observed.held.push_back({device::JointVector(pose.joints),
                                   {pose.marker.rotation, pose.marker.translation},
                                   pose.marker.covariance,
                                   pose.marker.systematic});
    return {};
  }

  Expected<void> touches() {
    std::vector<device::Request> places;
    for (const auto& surface : rig.surfaces)
      for (int i = 0; i < plan.corners_of_each; ++i)
        places.push_back({device::Gesture::touch, surface.name, i, {}, true});
    const int there = static_cast<int>(rig.landmarks.size()), wanted = std::min(plan.landmarks, there);
    for (int i = 0; i < wanted; ++i)
      places.push_back({device::Gesture::touch, "landmark", i * there / wanted, {}, true});
    const auto touched = record_touches(context, places, rig.pointer_pivot->tip_in_marker);
    if (!touched) return tl::unexpected(touched.error());
    for (const auto& touch : *touched)
      out.observed.touched.push_back({touch.what, touch.index, touch.X_world_pointer, touch.covariance});
    return {};
  }

  Expected<void> delay() {
    const auto moving = record_moving(context, plan.moving_s);
    if (!moving) return tl::unexpected(moving.error());
    // Whatever the arm's base and the tip are by now: any linear relation between the two will do.
    std::vector<TimedPoint> by_arm;
    for (std::size_t i = 0; i < moving->arm.size(); i += kArmEvery) {
      const auto& reading = moving->arm[i];
      by_arm.push_back(
          {reading.time_s, device::arm_tip(rig.arm->model, rig.arm->correction.apply(reading.joints)).m});
    }
    std::vector<device::StampedPose> by_tracker;
    for (const auto& pose : moving->marker)
      by_tracker.push_back({pose.time_s, pose.marker.rotation, pose.marker.translation});
    const auto delay =
        estimate_motion_delay(motion_of_points("arm", by_arm), motion_of_poses("stylus' marker", by_tracker),
                              {.longest_s = kLongestDelay});
    // A motion too poor for its delay says nothing against the rest.
    if (!delay) {
      out.no_delay = delay.error().message;
      return {};
    }
    out.delay_correlation = delay->correlation;
    if (delay->correlation < kMoveAlike) {
      out.no_delay = fmt::format(
          "arm and tracker do not move alike at any delay (correlation {:.3f}); one of them was held up, or "
          "the machine was: verify "
          "again",
          delay->correlation);
      return {};
    }
    out.observed.tracker_delay_s = delay->delay_s;
    out.observed.tracker_delay_std_s = std::hypot(
        delay->delay_std_s, delay_sd_of_systematic(*moving, by_arm, rig.arm->tip_in_marker.norm()));
    return {};
  }

  // Those of a picture that one pose of the camera explains, wherever it is: a dot taken for its neighbour is many pixels off.
  // What a refocused lens leaves, and everything that moved as a whole, is not.
  std::vector<vision::Sighting> that_agree(const vision::LandmarkFrame& frame) const {
    constexpr double kTurn = 0.1, kShift = 0.05, kAgree_px = 1.0;  // rad, m, px per axis
    vision::CameraPosePrior anywhere{frame.X_world_marker * rig.hand_eye->X_marker_camera, Matrix6::Zero()};
    anywhere.covariance.diagonal() << Vector3::Constant(kTurn * kTurn), Vector3::Constant(kShift * kShift);
    vision::RefinementOptions options;
    options.pixel_sd = kAgree_px;
    return vision::refine_camera_pose(rig.camera->model, anywhere, rig.landmarks, frame.sightings, options)
        .used;
  }

  Expected<void> pictures() {
    LandmarkFrameOptions options;
    options.seconds = plan.look_s;
    options.every = plan.every;
    if (rig.delays) options.camera_after_tracker_s = rig.delays->camera_after_tracker_s;
    WideFinder finder(hooks.find_landmarks);
    const auto frames = record_landmark_frames(
        context, *rig.camera, *rig.hand_eye, rig.landmarks, options,
        [&finder](const auto& image, const auto& camera, const auto& pose, const auto& landmarks) {
          return finder(image, camera, pose, landmarks);
        });
    if (!frames) return tl::unexpected(frames.error());
    for (const auto& one : *frames) {
      const auto agreeing = that_agree(one.frame);
      if (agreeing.size() < kFewestDots) continue;
      HeadFrame frame{one.frame.X_world_marker, one.frame.covariance, one.rate, {}};
      for (const auto& dot : agreeing) frame.dots.push_back({dot.landmark, dot.centre, dot.covariance});
      frame.time_s = one.time_s;
      out.observed.frames.push_back(std::move(frame));
    }
    if (out.observed.frames.empty())
      return refused(
          "pictures: the landmarks are not near the places where the camera should show them; it was moved "
          "by "
          "more than a few degrees, or they are hidden: uncover them, or calibrate hand-eye anew (palpate "
          "calibrate all, after taking [hand_eye] out of the rig file)");
    return {};
  }

  Expected<void> board() {
    const auto views = record_board_views(context, plan.board_s, plan.every);
    if (!views) return tl::unexpected(views.error());
    BoardFigure figure;
    double sum = 0.0;
    for (const auto& view : views->views) {
      vision::BoardPoseOptions any;
      any.max_rms_px = 100.0;  // a lens that is far off is what is looked for
      const auto pose = vision::board_pose(rig.camera->model, view, any);
      if (!pose) continue;
      ++figure.views;
      sum += pose->value.rms_px * pose->value.rms_px;
    }
    figure.rms_px = figure.views > 0 ? std::sqrt(sum / figure.views) : 0.0;
    figure.promised_px = rig.camera->from.rms_mm;
    if (figure.views > 0) out.board = figure;
    return {};
  }
};

Expected<void> verifiable(const rig::Rig& rig, const VerificationHooks& hooks) {
  const device::ArmModel& arm = rig.arm ? rig.arm->model : rig.nominal_arm;
  if (arm.kind == device::ArmModel::Kind::dh)
    return wrong_use("verification: the rig's arm {} is a chain of joints, which the session does not know",
                     arm.name);
  const auto need = [](bool there, const char* part) -> Expected<void> {
    if (there) return {};
    return refused("verification: the rig lacks its {}; palpate calibrate all finds it", part);
  };
  for (const auto& [there, part] : {std::pair(rig.arm.has_value(), "arm"),
                                    {rig.pointer_pivot.has_value(), "pointer_pivot"},
                                    {rig.camera.has_value(), "camera"},
                                    {rig.hand_eye.has_value(), "hand_eye"},
                                    {rig.landmarks.size() >= kFewestDots, "landmarks"},
                                    {static_cast<bool>(hooks.find_landmarks), "finder of landmarks"}})
    if (auto fine = need(there, part); !fine) return fine;
  return {};
}

}  // namespace

VerificationPlan VerificationPlan::quick() {
  VerificationPlan plan;
  plan.poses = 8;
  plan.corners_of_each = 2;
  plan.landmarks = 2;
  plan.moving_s = 0.0;
  plan.look_s = 4.0;
  plan.board_s = 0.0;
  return plan;
}

Expected<VerificationRecord> observe_rig(AcquisitionContext context, const rig::Rig& rig,
                                         const VerificationPlan& plan, const VerificationHooks& hooks) {
  if (auto fine = verifiable(rig, hooks); !fine) return tl::unexpected(fine.error());
  VerificationRecord out;
  Look look{context, rig, plan, hooks, out};
  struct Step {
    const char* name;
    Expected<void> (Look::*run)();
    bool wanted;
  };
  std::vector<Step> steps;
  for (const Step& step :
       {Step{"rest", &Look::rest, true}, Step{"stylus in poses", &Look::stylus, plan.poses > 0},
        Step{"stylus moved", &Look::delay, plan.moving_s > 0.0},
        Step{"touches", &Look::touches, plan.corners_of_each + plan.landmarks > 0},
        Step{"pictures", &Look::pictures, plan.look_s > 0.0},
        Step{"board", &Look::board, plan.board_s > 0.0}})
    if (step.wanted) steps.push_back(step);
  const double began = context.clock.now().seconds();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (hooks.progress) hooks.progress(i, steps.size(), steps[i].name);
    const auto done = (look.*steps[i].run)();
    if (context.stopped()) return refused(ErrorCode::stopped, "{}: stopped", steps[i].name);
    if (!done) return tl::unexpected(done.error());
  }
  out.seconds = context.clock.now().seconds() - began;
  return out;
}

}  // namespace palpate::calibration::session
