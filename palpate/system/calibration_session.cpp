#include "palpate/system/calibration_session.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/camera.h"
#include "palpate/calibration/gimbal.h"
#include "palpate/calibration/hand_eye.h"
#include "palpate/calibration/landmark_refinement.h"
#include "palpate/calibration/pivot.h"
#include "palpate/calibration/second_camera.h"
#include "palpate/calibration/stream_delay.h"
#include "palpate/calibration/surface.h"
#include "palpate/calibration/touched_landmarks.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/graphics_server/marker_history.h"

namespace palpate {
namespace {

template <typename T>
tl::unexpected<Error> failed(const Expected<T>& step) {
  return tl::unexpected(step.error());
}

Provenance provenance(const CalibrationPlan& plan, const std::string& data, const std::string& method,
                      double rms_mm) {
  return {plan.date, content_hash(data), method, rms_mm};
}

std::string bytes_of(const std::vector<TrackedPose>& poses) {
  std::string bytes;
  for (const auto& pose : poses)
    bytes.append(reinterpret_cast<const char*>(pose.marker.translation.data()), 3 * sizeof(double));
  return bytes;
}

// With the tip's motion as an arm of these lengths saw it; without lengths no arm held it.
std::vector<PivotPose> pivot_poses(const std::vector<TrackedPose>& poses,
                                   const std::optional<PhantomLengths>& lengths = std::nullopt) {
  std::vector<PivotPose> result;
  for (const auto& pose : poses) {
    result.push_back({pose.marker.rotation, pose.marker.translation, 0, std::nullopt, pose.time_s});
    if (lengths) result.back().motion = phantom_tip(pose.joints, *lengths).m;
  }
  return result;
}

PivotCalibration rig_pivot(const Estimate<PivotSolution>& estimate, const Provenance& from) {
  return {estimate.value.tip, estimate.covariance.topLeftCorner<3, 3>(), from};
}

// The board looks the same after half a turn, and the detector numbers its corners from either end. Our board
// has a dark square outside its first corner and a light one outside its last: that tells the two apart.
std::vector<Pixel> numbered(std::vector<Pixel> corners, const BoardShape& shape,
                            const std::vector<std::uint8_t>& grey, int width, int height) {
  const auto brightness = [&](const Pixel& p) -> double {
    const int u = static_cast<int>(std::lround(p.x())), v = static_cast<int>(std::lround(p.y()));
    double sum = 0.0;
    int count = 0;
    for (int dv = -1; dv <= 1; ++dv)
      for (int du = -1; du <= 1; ++du) {
        const int x = std::clamp(u + du, 0, width - 1), y = std::clamp(v + dv, 0, height - 1);
        sum +=
            grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
        ++count;
      }
    return sum / count;
  };
  const auto at = [&](int column, int row) {
    return corners[static_cast<std::size_t>(row * shape.columns + column)];
  };
  // Middle of the square diagonally outside a corner, by the step from the corner diagonally inside.
  const Pixel first = at(0, 0) + 0.5 * (at(0, 0) - at(1, 1));
  const Pixel last = at(shape.columns - 1, shape.rows - 1) +
                     0.5 * (at(shape.columns - 1, shape.rows - 1) - at(shape.columns - 2, shape.rows - 2));
  if (brightness(first) > brightness(last)) std::reverse(corners.begin(), corners.end());
  return corners;
}

struct Steps {
  Laboratory lab;
  Rig& rig;
  const CalibrationPlan& plan;
  const SessionHooks& hooks;
  CalibrationRecordings& out;
  bool lens_new = false;

  Expected<void> pointer() {
    auto poses = record_pointer_pivot(lab, plan.pivot_poses / 2, plan.pivot_s / 2);
    if (!poses) return failed(poses);
    PivotCalibrationOptions options;
    options.method = PivotMethod::robust;
    options.shared_errors = true;
    auto estimate = calibrate_pivot(pivot_poses(*poses), options);
    if (!estimate) return failed(estimate);
    rig.pointer_pivot = rig_pivot(
        *estimate,
        provenance(plan, bytes_of(*poses), "robust", mm_from_metres(rms_per_component(estimate->residuals))));
    out.pointer_pivot = std::move(*poses);
    return {};
  }

  Expected<void> surfaces() {
    rig.surfaces.clear();
    std::vector<SurfaceTouches> touched;
    for (const std::string name : {"table", "wall"}) {
      std::vector<Request> requests;
      for (int round = 0; round < plan.corner_rounds; ++round)
        for (const auto& request : corner_requests(name)) requests.push_back(request);
      auto touches = record_touches(lab, requests, rig.pointer_pivot->tip_in_marker);
      if (!touches) return failed(touches);
      touched.push_back({name, {}});
      for (const auto& touch : *touches)
        touched.back().points.push_back({{touch.place}, touch.index + 1, touch.covariance});
      out.corners.insert(out.corners.end(), touches->begin(), touches->end());
    }
    const auto fits = fit_rectangles(touched);
    if (!fits) return failed(fits);
    for (std::size_t i = 0; i < touched.size(); ++i) {
      std::string data;
      for (const auto& point : touched[i].points)
        data += fmt::format("{} {} {};", point.place.m.x(), point.place.m.y(), point.place.m.z());
      const auto& fit = (*fits)[i];
      const RectangleFit& r = fit.value;
      rig.surfaces.push_back(
          {touched[i].name, r.X_world_rectangle, r.width, r.height, fit.covariance,
           provenance(plan, data, "rectangle", mm_from_metres(rms_per_component(fit.residuals))), r.seen});
    }
    return {};
  }

  Expected<void> landmarks() {
    std::vector<LandmarkTouch> touched;
    for (int i = 0;; ++i) {
      auto touch = record_touches(lab, {{Gesture::touch, "landmark", i}}, rig.pointer_pivot->tip_in_marker);
      if (!touch) {
        if (i < 3) return failed(touch);
        break;  // the person says there are no more
      }
      touched.push_back({std::to_string(i), touch->front().place, touch->front().covariance});
      out.landmark_touches.push_back(touch->front());
    }
    auto found = landmarks_from_touches(touched, rig.surfaces, {.touch = touch_noise_of(rig.surfaces)});
    if (!found) return failed(found);
    rig.landmarks = std::move(found->value.landmarks);
    return {};
  }

  Expected<void> tip() {
    PivotRecordingOptions options;
    options.poses = plan.pivot_poses;
    options.seconds = plan.pivot_s;
    options.fixation.nominal = rig.nominal_lengths;
    auto poses = record_pivot(lab, options);
    if (!poses) return failed(poses);
    // The paper's way, which the methods of the paper go on from: the motion of the held tip stays in the
    // tip, and in its covariance. The joint solve of the arm finds the tip anew.
    auto estimate = calibrate_pivot(pivot_poses(*poses, rig.nominal_lengths), {.shared_errors = true});
    if (!estimate) return failed(estimate);
    rig.tip_pivot = rig_pivot(*estimate, provenance(plan, bytes_of(*poses), "algebraic",
                                                    mm_from_metres(rms_per_component(estimate->residuals))));
    out.tip_pivot = std::move(*poses);
    return {};
  }

  Expected<void> arm() {
    auto rest = record_rest(lab);
    if (!rest) return failed(rest);
    ArmOptions options;
    options.free.lengths = false;
    options.tip = rig.tip_pivot->tip_in_marker;
    GuidanceOptions guidance;
    guidance.model.lengths = rig.nominal_lengths;
    guidance.arm = options;
    guidance.tip = rig.tip_pivot->tip_in_marker;
    guidance.reach = plan.reach;
    guidance.seed = plan.guidance_seed;
    guidance.report = [this](const GuidanceState& state) {
      if (hooks.guidance) hooks.guidance(state, plan.arm_points);
    };
    GuidedPoses guide(guidance);
    auto poses =
        plan.guided ? record_arm(lab, guide.recording(plan.arm_points)) : record_arm(lab, plan.arm_points);
    if (!poses) return failed(poses);
    const auto unguided = record_arm(lab, plan.arm_test_points);
    if (!unguided) return failed(unguided);
    poses->insert(poses->end(), unguided->begin(), unguided->end());
    auto samples = arm_observations(*poses, rig.tip_pivot->tip_in_marker);
    out.arm_train.assign(samples.begin(), samples.begin() + plan.arm_points);
    out.arm_test.assign(samples.begin() + plan.arm_points, samples.end());
    auto estimate = calibrate_arm(out.arm_train, ArmModel{.lengths = rig.nominal_lengths}, options);
    if (!estimate) return failed(estimate);
    const auto gimbal = calibrate_gimbal(out.arm_train, *estimate);
    if (!gimbal) return failed(gimbal);
    rig.arm = rig_arm(*estimate);
    put_gimbal_into(*rig.arm, gimbal->value);
    rig.arm->rest_readings = *rest;
    rig.arm->held_out_mean = mean_norm(arm_errors(estimate->value, out.arm_test));
    rig.arm->from =
        provenance(plan, bytes_of(*poses), "joint", mm_from_metres(rms_per_component(estimate->residuals)));
    DesignOptions design;
    design.free = options.free;
    out.arm_predicted = predicted_error_curve(estimate->value, out.arm_train, plan.reach, design);
    out.arm_predicted_random = predicted_error_curve(estimate->value, out.arm_test, plan.reach, design);
    out.arm_poses = std::move(*poses);
    return {};
  }

  Expected<void> arm_delay() {
    auto moving = record_moving(lab, plan.moving_s);
    if (!moving) return failed(moving);
    std::vector<TimedPoint> by_arm, by_tracker;
    for (const auto& reading : moving->arm)
      by_arm.push_back(
          {reading.time_s,
           (rig.arm->X_world_base * phantom_tip(rig.arm->correction.apply(reading.joints), rig.arm->lengths))
               .m});
    for (const auto& pose : moving->marker)
      by_tracker.push_back(
          {pose.time_s, pose.marker.translation + pose.marker.rotation * rig.arm->tip_in_marker});
    auto delay = estimate_stream_delay(by_arm, by_tracker);
    if (!delay) return failed(delay);
    if (!rig.delays) rig.delays.emplace();
    rig.delays->tracker_after_arm_s = delay->value.delay_s;
    rig.delays->tracker_std_s = delay->standard_deviation(0);
    return {};
  }

  Expected<void> camera() { return camera(lab, rig.camera, rig.hand_eye, out.camera, true); }
  Expected<void> right_camera() {
    return camera(right_lab(), rig.right_camera, rig.right_hand_eye, out.right_camera, false);
  }

  // The laboratory as the second camera's user has it.
  Laboratory right_lab() const {
    Laboratory right = lab;
    right.camera = lab.right_camera;
    return right;
  }

  // Lens and hand-eye from one movement of the head around the board. The cameras expose together: the delay
  // of the first is that of both.
  Expected<void> camera(const Laboratory& seen, std::optional<CameraCalibration>& camera_out,
                        std::optional<HandEyeCalibration>& hand_eye_out, CameraRecordings& recorded,
                        bool delay_too) const {
    const BoardShape shape;
    std::vector<BoardView> views;
    int width = 0, height = 0;
    auto record = record_views(seen, Gesture::look_around_board, plan.board_s, plan.board_every,
                               [&](const CameraImage& image) {
                                 width = image.width;
                                 height = image.height;
                                 const auto grey = grey_from_rgb(image.rgb);
                                 const auto corners = find_board_corners(grey, width, height, shape);
                                 if (!corners) return false;
                                 BoardView view;
                                 view.name = fmt::format("image {}", image.frame);
                                 view.image = numbered(*corners, shape, grey, width, height);
                                 for (int i = 0; i < shape.corners(); ++i)
                                   view.board.push_back(shape.corner(i));
                                 views.push_back(std::move(view));
                                 return true;
                               });
    if (!record) return failed(record);
    constexpr std::size_t kFewest = 12;
    if (views.size() < kFewest)
      return refused(
          "camera: the board was found in {}, at least {} are needed; keep all of it in view, in good "
          "light",
          counted(views.size(), "image"), kFewest);
    // Views spread evenly over the movement.
    std::vector<BoardView> chosen;
    const std::size_t wanted = std::min(views.size(), static_cast<std::size_t>(plan.lens_views));
    for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(views[i * views.size() / wanted]);
    auto lens = calibrate_camera(chosen, width, height);
    if (!lens) return failed(lens);
    camera_out = CameraCalibration{lens->value.model, lens->covariance,
                                   provenance(plan, views.front().name, "chessboard", lens->value.rms_px)};

    std::vector<StampedPose> hand, eye;
    for (const auto& pose : record->tracked)
      hand.push_back({pose.time_s, pose.marker.rotation, pose.marker.translation});
    for (std::size_t i = 0; i < views.size(); ++i) {
      const auto pose = board_pose(lens->value.model, views[i]);
      if (!pose || pose->value.ambiguous) continue;
      const auto X_board_camera = pose->value.X_camera_board.inverse();
      eye.push_back({record->image_times_s[i], X_board_camera.rotation, X_board_camera.translation});
      recorded.eye.push_back({record->image_times_s[i], X_board_camera});
    }
    HandEyeOptions options;
    options.estimate_delay = true;
    auto estimate = calibrate_hand_eye(hand, eye, options);
    if (!estimate) return failed(estimate);
    HandEyeCalibration hand_eye;
    hand_eye.X_marker_camera = estimate->value.X_marker_camera;
    hand_eye.covariance = estimate->covariance.topLeftCorner<6, 6>();
    hand_eye.from = provenance(plan, bytes_of(record->tracked), "hand-eye",
                               mm_from_metres(estimate->value.translation_rms));
    hand_eye_out = hand_eye;
    if (delay_too) {
      if (!rig.delays) rig.delays.emplace();
      rig.delays->camera_after_tracker_s = -estimate->value.delay_s;  // hand time = eye time + delay
      rig.delays->camera_std_s = estimate->value.delay_std_s;
    }
    recorded.lens_views = std::move(chosen);
    recorded.hand = std::move(record->hand);
    return {};
  }

  // Lens, hand-eye and landmarks of one solve are the rig's.
  Expected<void> landmarks_again() {
    auto refined =
        landmarks_from_pictures(lab, rig.camera, rig.hand_eye, out.camera, touch_noise_of(rig.surfaces));
    if (!refined) return failed(refined);
    if (!*refined) return {};
    rig.registration_covariance = (*refined)->covariance;
    rig.landmarks = (*refined)->value.landmarks;
    return {};
  }

  // The second camera is fitted to the landmarks where the first one's pictures have put them; nobody touches
  // them again.
  Expected<void> right_landmarks() {
    auto refined = landmarks_from_pictures(right_lab(), rig.right_camera, rig.right_hand_eye,
                                           out.right_camera, std::nullopt);
    if (!refined) return failed(refined);
    if (!*refined) return {};
    const auto right = fit_second_camera(**refined, rig.landmarks, registration_covariance(rig));
    rig.right_camera->model = right.camera.model;
    rig.right_camera->covariance = right.camera.covariance;
    rig.right_hand_eye->X_marker_camera = right.hand_eye.X_marker_camera;
    rig.right_hand_eye->covariance = right.hand_eye.covariance;
    rig.right_registration_covariance = right.covariance;
    return {};
  }

  // Improves lens and hand-eye; nothing where nobody finds landmarks.
  Expected<std::optional<Estimate<LandmarkRefinement>>> landmarks_from_pictures(
      const Laboratory& seen, std::optional<CameraCalibration>& camera_out,
      std::optional<HandEyeCalibration>& hand_eye_out, CameraRecordings& recorded,
      const std::optional<TouchNoise>& touch) const {
    if (!hooks.find_landmarks) return std::nullopt;
    std::vector<CameraImage> images;
    constexpr int every = 3;  // neighbours say the same again
    auto record = record_views(seen, Gesture::look, plan.look_s, every, [&](const CameraImage& image) {
      images.push_back(image);
      return true;
    });
    if (!record) return failed(record);
    MarkerHistory history(seconds(0.1), seconds(1e4));
    for (const auto& pose : record->tracked)
      history.add({Instant<GraphicsClock>::from_seconds(pose.time_s), pose.marker.rotation,
                   pose.marker.translation, pose.marker.covariance});
    std::vector<LandmarkFrame> frames;
    for (std::size_t i = 0; i < images.size(); ++i) {
      const auto marker = history.at(Instant<GraphicsClock>::from_seconds(
          record->image_times_s[i] - rig.delays->camera_after_tracker_s));
      if (!marker) continue;
      LandmarkFrame frame;
      frame.X_world_marker = {marker->rotation, marker->translation};
      frame.covariance = marker->covariance;
      frame.sightings = hooks.find_landmarks(
          images[i], *camera_out, frame.X_world_marker * hand_eye_out->X_marker_camera, rig.landmarks);
      frames.push_back(std::move(frame));
    }
    auto refined = refine_landmarks(*camera_out, *hand_eye_out, rig.landmarks, frames,
                                    {.pixel_sd = kUnstatedSightingSd, .touch = touch});
    if (!refined) return failed(refined);
    camera_out->model = refined->value.camera.model;
    camera_out->covariance = refined->value.camera.covariance;
    hand_eye_out->X_marker_camera = refined->value.hand_eye.X_marker_camera;
    hand_eye_out->covariance = refined->value.hand_eye.covariance;
    recorded.landmark_rms_px_before = refined->value.rms_px_before;
    recorded.landmark_rms_px = refined->value.rms_px;
    return std::move(*refined);
  }
};

}  // namespace

std::vector<ArmObservation> arm_observations(const std::vector<TrackedPose>& poses, const Vector3& tip) {
  std::vector<ArmObservation> result;
  for (const auto& pose : poses) {
    ArmObservation sample;
    sample.joints = pose.joints;
    sample.gimbal = pose.gimbal;
    sample.time_s = pose.time_s;
    sample.marker = Pose<World, TipMarker>{pose.marker.rotation, pose.marker.translation};
    sample.covariance = pose.marker.point_covariance(tip);
    sample.systematic = std::sqrt(pose.marker.systematic.trace());
    result.push_back(sample);
  }
  return result;
}

ArmCalibration rig_arm(const Estimate<ArmSolution>& estimate) {
  ArmCalibration arm;
  const auto& s = estimate.value;
  arm.lengths = s.model.lengths;
  arm.correction.gain = s.gain.head<3>();
  arm.correction.offset = s.offset.head<3>();
  arm.X_world_base = s.X_world_base;
  arm.tip_in_marker = s.tip_in_marker;
  // The rig's order is fixed; what was not estimated has no variance.
  const std::vector<std::string> order{"gain_1",
                                       "gain_2",
                                       "gain_3",
                                       "offset_1",
                                       "offset_2",
                                       "offset_3",
                                       "base_rotation_x",
                                       "base_rotation_y",
                                       "base_rotation_z",
                                       "base_translation_x",
                                       "base_translation_y",
                                       "base_translation_z",
                                       "tip_x",
                                       "tip_y",
                                       "tip_z"};
  arm.covariance = Eigen::MatrixXd::Zero(15, 15);
  std::vector<Eigen::Index> place(order.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto at = std::find(s.parameters.begin(), s.parameters.end(), order[i]);
    if (at != s.parameters.end()) place[i] = at - s.parameters.begin();
  }
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = 0; j < order.size(); ++j)
      if (place[i] >= 0 && place[j] >= 0 && estimate.covariance.rows() > std::max(place[i], place[j]))
        arm.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            estimate.covariance(place[i], place[j]);
  return arm;
}

Expected<CalibrationRecordings> calibrate_rig(Laboratory lab, Rig& rig, const CalibrationPlan& plan,
                                              const SessionHooks& hooks) {
  CalibrationRecordings out;
  Steps steps{lab, rig, plan, hooks, out};
  const bool surfaces_there = rig.surface("table") != nullptr && rig.surface("wall") != nullptr;
  struct Step {
    std::string name;
    bool there;
    Expected<void> (Steps::*run)();
  };
  std::vector<Step> list{
      {"pointer tip", rig.pointer_pivot.has_value(), &Steps::pointer},
      {"table and wall", surfaces_there, &Steps::surfaces},
      {"landmarks", !rig.landmarks.empty(), &Steps::landmarks},
      {"stylus tip", rig.tip_pivot.has_value(), &Steps::tip},
      {"arm", rig.arm.has_value(), &Steps::arm},
      {"delay of the tracker", rig.delays && rig.delays->tracker_known(), &Steps::arm_delay},
      {"lens and hand-eye", rig.camera.has_value() && rig.hand_eye.has_value(), &Steps::camera},
      {"landmarks from pictures", rig.camera.has_value() && rig.hand_eye.has_value(),
       &Steps::landmarks_again},
  };
  if (lab.right_camera != nullptr) {
    list.push_back({"lens and hand-eye of the right camera", has_two_eyes(rig), &Steps::right_camera});
    list.push_back(
        {"landmarks from pictures of the right camera", has_two_eyes(rig), &Steps::right_landmarks});
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (hooks.progress) hooks.progress(i, list.size(), list[i].name);
    if (list[i].there) continue;
    if (auto done = (steps.*list[i].run)(); !done) return tl::unexpected(done.error());
    if (hooks.save)
      if (auto saved = hooks.save(rig); !saved) return tl::unexpected(saved.error());
  }
  return out;
}

}  // namespace palpate
