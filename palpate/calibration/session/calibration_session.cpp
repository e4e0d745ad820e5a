#include "palpate/calibration/session/calibration_session.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/gimbal.h"
#include "palpate/calibration/pivot.h"
#include "palpate/calibration/session/camera_session.h"
#include "palpate/calibration/session/step_words.h"
#include "palpate/calibration/stream_delay.h"
#include "palpate/calibration/surface.h"
#include "palpate/calibration/touched_landmarks.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/vision/second_camera.h"

namespace palpate::calibration::session {
namespace {

// With the tip's motion as this arm saw it; without one no arm held it.
std::vector<PivotPose> pivot_poses(const std::vector<TrackedPose>& poses,
                                   const device::ArmModel* arm = nullptr) {
  std::vector<PivotPose> result;
  for (const auto& pose : poses) {
    result.push_back({pose.marker.rotation, pose.marker.translation, 0, std::nullopt, pose.time_s});
    if (arm != nullptr) result.back().motion = device::arm_tip(*arm, pose.joints).m;
  }
  return result;
}

rig::PivotCalibration rig_pivot(const Estimate<PivotSolution>& estimate, const rig::Provenance& from) {
  return {estimate.value.tip, estimate.covariance.topLeftCorner<3, 3>(), from};
}

constexpr int kFewestLandmarks = 3;

struct Steps {
  AcquisitionContext context;
  rig::Rig& rig;
  const CalibrationPlan& plan;
  const SessionHooks& hooks;
  CalibrationRecordings& out;

  Expected<void> pointer() {
    auto poses = record_pointer_pivot(context, plan.pivot_poses / 2, plan.pivot_s / 2);
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

  // Those that the rig has are kept.
  Expected<void> surfaces() {
    out.corners.clear();
    std::vector<SurfaceTouches> touched;
    for (const std::string name : {"table", "wall"}) {
      if (rig.surface(name) != nullptr) continue;
      std::vector<device::Request> requests;
      for (int round = 0; round < plan.corner_rounds; ++round)
        for (const auto& request : corner_requests(name)) requests.push_back(request);
      auto touches = record_touches(context, requests, rig.pointer_pivot->tip_in_marker);
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
    out.landmark_touches.clear();
    std::vector<LandmarkTouch> touched;
    for (int i = 0;; ++i) {
      auto touch = record_touches(context, {{device::Gesture::touch, "landmark", i}},
                                  rig.pointer_pivot->tip_in_marker);
      // Only the person can say that these were all; any other failure is one.
      if (!touch && i >= kFewestLandmarks && touch.error().code == ErrorCode::no_more) break;
      if (!touch) return failed(touch);
      touched.push_back({std::to_string(i), touch->front().place, touch->front().covariance});
      out.landmark_touches.push_back(touch->front());
    }
    auto found =
        landmarks_from_touches(touched, rig.surfaces, {.touch = noise::touch_noise_of(rig.surfaces)});
    if (!found) return failed(found);
    rig.landmarks = std::move(found->value.landmarks);
    rig.landmarks_from = provenance(plan, bytes_of(out.landmark_touches), "touched",
                                    mm_from_metres(rms_per_component(found->residuals)));
    return {};
  }

  Expected<void> tip() {
    PivotRecordingOptions options;
    options.poses = plan.pivot_poses;
    options.seconds = plan.pivot_s;
    options.fixation.nominal = rig.nominal_arm;
    auto poses = record_pivot(context, options);
    if (!poses) return failed(poses);
    // The paper's way, which the methods of the paper go on from: the motion of the held tip stays in the
    // tip, and in its covariance. The joint solve of the arm finds the tip anew.
    auto estimate = calibrate_pivot(pivot_poses(*poses, &rig.nominal_arm), {.shared_errors = true});
    if (!estimate) return failed(estimate);
    rig.tip_pivot = rig_pivot(*estimate, provenance(plan, bytes_of(*poses), "algebraic",
                                                    mm_from_metres(rms_per_component(estimate->residuals))));
    out.tip_pivot = std::move(*poses);
    return {};
  }

  Expected<void> arm() {
    auto rest = record_rest(context);
    if (!rest) return failed(rest);
    ArmOptions options;
    options.free.lengths = false;
    options.tip = rig.tip_pivot->tip_in_marker;
    GuidanceOptions guidance;
    guidance.model = rig.nominal_arm;
    guidance.arm = options;
    guidance.tip = rig.tip_pivot->tip_in_marker;
    guidance.reach = plan.reach;
    guidance.seed = plan.guidance_seed;
    guidance.report = [this](const GuidanceState& state) {
      if (hooks.guidance) hooks.guidance(state, plan.arm_points);
    };
    GuidedPoses guide(guidance);
    const bool phantom = rig.nominal_arm.kind == device::ArmModel::Kind::phantom;
    // Guidance reckons with joints; an arm that states its place has none.
    auto poses = plan.guided && phantom ? record_arm(context, guide.recording(plan.arm_points))
                                        : record_arm(context, plan.arm_points);
    if (!poses) return failed(poses);
    const auto unguided = record_arm(context, plan.arm_test_points);
    if (!unguided) return failed(unguided);
    poses->insert(poses->end(), unguided->begin(), unguided->end());
    auto samples = arm_observations(*poses, rig.tip_pivot->tip_in_marker);
    out.arm_train.assign(samples.begin(), samples.begin() + plan.arm_points);
    out.arm_test.assign(samples.begin() + plan.arm_points, samples.end());
    auto estimate = calibrate_arm(out.arm_train, rig.nominal_arm, options);
    if (!estimate) return failed(estimate);
    rig.arm = rig_arm(*estimate);
    if (phantom) {
      const auto gimbal = calibrate_gimbal(out.arm_train, *estimate);
      if (!gimbal) return failed(gimbal);
      put_gimbal_into(*rig.arm, gimbal->value);
    }
    rig.arm->rest_readings = *rest;
    rig.arm->rest_known = true;
    rig.arm->held_out_mean = mean_norm(arm_errors(estimate->value, out.arm_test));
    rig.arm->from =
        provenance(plan, bytes_of(*poses), "joint", mm_from_metres(rms_per_component(estimate->residuals)));
    out.arm_poses = std::move(*poses);
    if (!phantom) return {};
    DesignOptions design;
    design.free = options.free;
    out.arm_predicted = predicted_error_curve(estimate->value, out.arm_train, plan.reach, design);
    out.arm_predicted_random = predicted_error_curve(estimate->value, out.arm_test, plan.reach, design);
    return {};
  }

  Expected<void> arm_delay() {
    auto moving = record_moving(context, plan.moving_s);
    if (!moving) return failed(moving);
    std::vector<TimedPoint> by_arm, by_tracker;
    for (const auto& reading : moving->arm)
      by_arm.push_back(
          {reading.time_s, (rig.arm->X_world_base *
                            device::arm_tip(rig.arm->model, rig.arm->correction.apply(reading.joints)))
                               .m});
    for (const auto& pose : moving->marker)
      by_tracker.push_back(
          {pose.time_s, pose.marker.translation + pose.marker.rotation * rig.arm->tip_in_marker});
    auto delay = estimate_stream_delay(by_arm, by_tracker);
    if (!delay) return failed(delay);
    if (!rig.delays) rig.delays.emplace();
    rig.delays->tracker_after_arm_s = delay->value.delay_s;
    rig.delays->tracker_std_s =
        std::hypot(delay->standard_deviation(0),
                   delay_sd_of_systematic(*moving, by_tracker, rig.arm->tip_in_marker.norm()));
    return {};
  }

  CameraSession left_eye() { return {context, plan, {rig.camera, rig.hand_eye}, out.camera}; }
  CameraSession right_eye() {
    return {right_context(), plan, {rig.right_camera, rig.right_hand_eye}, out.right_camera};
  }

  Expected<void> camera() {
    const auto delay = left_eye().lens_and_hand_eye();
    if (!delay) return failed(delay);
    if (!rig.delays) rig.delays.emplace();
    rig.delays->camera_after_tracker_s = delay->seconds;
    rig.delays->camera_std_s = delay->std_s;
    return {};
  }

  // The cameras expose together: the delay of the first is that of both.
  Expected<void> right_camera() {
    const auto delay = right_eye().lens_and_hand_eye();
    if (!delay) return failed(delay);
    return {};
  }

  // The laboratory as the second camera's user has it.
  AcquisitionContext right_context() const {
    AcquisitionContext right = context;
    right.camera = context.right_camera;
    return right;
  }

  // Nothing where nobody finds landmarks.
  Expected<std::optional<Estimate<vision::LandmarkRefinement>>> from_pictures(
      CameraSession eye, const std::optional<rig::TouchNoise>& touch) const {
    if (!hooks.find_landmarks) return std::nullopt;
    return eye.landmarks_from_pictures(rig.landmarks, rig.delays->camera_after_tracker_s,
                                       hooks.find_landmarks, touch);
  }

  // Lens, hand-eye and landmarks of one solve are the rig's.
  Expected<void> landmarks_again() {
    auto refined = from_pictures(left_eye(), noise::touch_noise_of(rig.surfaces));
    if (!refined) return failed(refined);
    if (!*refined) return {};
    rig.registration_covariance = (*refined)->covariance;
    rig.landmarks = (*refined)->value.landmarks;
    // By how much the pictures have moved them.
    rig.landmarks_from = provenance(plan, bytes_of(out.landmark_touches), "head-motion",
                                    mm_from_metres(rms_per_component((*refined)->residuals)));
    return {};
  }

  // The second camera is fitted to the landmarks where the first one's pictures have put them; nobody touches
  // them again.
  Expected<void> right_landmarks() {
    auto refined = from_pictures(right_eye(), std::nullopt);
    if (!refined) return failed(refined);
    if (!*refined) return {};
    const auto right = vision::fit_second_camera(**refined, rig.landmarks, rig::registration_covariance(rig));
    rig.right_camera->model = right.camera.model;
    rig.right_camera->covariance = right.camera.covariance;
    rig.right_hand_eye->X_marker_camera = right.hand_eye.X_marker_camera;
    rig.right_hand_eye->covariance = right.hand_eye.covariance;
    rig.right_registration_covariance = right.covariance;
    return {};
  }
};

struct Step {
  std::string name;
  Expected<void> (Steps::*run)();
  std::function<bool(const rig::Rig&)> there;
  std::function<std::string(const rig::Rig&)> words;
};

// In their order.
std::vector<Step> steps_for(const AcquisitionContext& context) {
  using rig::Rig;
  std::vector<Step> list{
      {"pointer tip", &Steps::pointer, [](const Rig& r) { return r.pointer_pivot.has_value(); },
       [](const Rig& r) { return words_of_pivot(*r.pointer_pivot); }},
      {"table and wall", &Steps::surfaces,
       [](const Rig& r) { return r.surface("table") != nullptr && r.surface("wall") != nullptr; },
       words_of_surfaces},
      {"landmarks", &Steps::landmarks, [](const Rig& r) { return !r.landmarks.empty(); }, words_of_landmarks},
      {"stylus tip", &Steps::tip, [](const Rig& r) { return r.tip_pivot.has_value(); },
       [](const Rig& r) { return words_of_pivot(*r.tip_pivot); }},
      {"arm", &Steps::arm, [](const Rig& r) { return r.arm.has_value(); },
       [](const Rig& r) { return words_of_arm(*r.arm); }},
      {"delay of the tracker", &Steps::arm_delay,
       [](const Rig& r) { return r.delays && r.delays->tracker_known(); },
       [](const Rig& r) { return words_of_delay(r.delays->tracker_after_arm_s, r.delays->tracker_std_s); }},
      {"lens and hand-eye", &Steps::camera,
       [](const Rig& r) { return r.camera.has_value() && r.hand_eye.has_value(); },
       [](const Rig& r) { return words_of_camera(*r.camera, *r.hand_eye); }},
      {"landmarks from pictures", &Steps::landmarks_again,
       [](const Rig& r) { return r.registration_covariance.size() > 0; }, words_of_places},
  };
  if (context.right_camera != nullptr) {
    list.push_back({"lens and hand-eye of the right camera", &Steps::right_camera,
                    [](const Rig& r) { return rig::has_two_eyes(r); },
                    [](const Rig& r) { return words_of_camera(*r.right_camera, *r.right_hand_eye); }});
    list.push_back({"landmarks from pictures of the right camera", &Steps::right_landmarks,
                    [](const Rig& r) { return r.right_registration_covariance.size() > 0; },
                    words_of_places});
  }
  return list;
}

// The steps one after the other, as whoever reviews them decides; the rig as it was before each that was done now.
class Course {
 public:
  Course(Steps& steps, const SessionHooks& hooks) : steps_(steps), hooks_(hooks) {}

  Expected<void> run(const std::vector<Step>& list) {
    for (std::size_t i = 0; i < list.size();) {
      if (hooks_.progress) hooks_.progress(i, list.size(), list[i].name);
      if (list[i].there(steps_.rig)) {
        if (hooks_.kept) hooks_.kept(list[i].name, list[i].words(steps_.rig));
        ++i;
        continue;
      }
      before_.push_back({i, steps_.rig});
      const auto done = (steps_.*list[i].run)();
      if (steps_.context.stopped()) return stopped(list[i]);
      const auto next = judge(list[i], done);
      if (!next) return tl::unexpected(next.error());
      i = *next;
    }
    return {};
  }

 private:
  struct Before {
    std::size_t step;
    rig::Rig rig;
  };

  static tl::unexpected<Error> stopped(const Step& step) {
    return refused(ErrorCode::stopped,
                   "{}: stopped; the steps before it are kept, and the same command goes on with this one",
                   step.name);
  }

  // The step to go on with, after the newest.
  Expected<std::size_t> judge(const Step& step, const Expected<void>& done) {
    const std::size_t i = before_.back().step;
    if (done)
      if (auto saved = save(); !saved) return tl::unexpected(saved.error());
    if (done && hooks_.recorded) hooks_.recorded(steps_.out);
    if (!done && done.error().code == ErrorCode::stopped) return stopped(step);
    if (!done && !hooks_.review) return tl::unexpected(done.error());
    if (!hooks_.review) return i + 1;
    const bool found = done && step.there(steps_.rig);
    const std::string words = !done ? done.error().message : found ? step.words(steps_.rig) : "nothing to do";
    switch (hooks_.review({step.name, done.has_value(), words, before_.size() < 2})) {
      case Review::go_on:
        if (!done) return tl::unexpected(done.error());
        return i + 1;
      case Review::repeat:
        return back();
      case Review::undo:
        if (before_.size() > 1) before_.pop_back();
        return back();
      case Review::stop:
        break;
    }
    if (done)
      return refused(ErrorCode::stopped,
                     "{}: done; stopped after it, and the same command goes on with the next", step.name);
    steps_.rig = before_.back().rig;
    return stopped(step);
  }

  Expected<std::size_t> back() {
    const std::size_t i = before_.back().step;
    steps_.rig = std::move(before_.back().rig);
    before_.pop_back();
    if (auto saved = save(); !saved) return tl::unexpected(saved.error());
    return i;
  }

  Expected<void> save() const { return hooks_.save ? hooks_.save(steps_.rig) : Expected<void>{}; }

  Steps& steps_;
  const SessionHooks& hooks_;
  std::vector<Before> before_;
};

}  // namespace

Expected<CalibrationRecordings> calibrate_rig(AcquisitionContext context, rig::Rig& rig,
                                              const CalibrationPlan& plan, const SessionHooks& hooks) {
  if (rig.nominal_arm.kind == device::ArmModel::Kind::dh)
    return wrong_use(
        "calibration: the rig's arm {} is a chain of joints, which the session does not know; calibrate it "
        "from recorded samples (palpate calibrate arm)",
        rig.nominal_arm.name);
  if (rig.arm && rig.arm->model.kind != rig.nominal_arm.kind)
    return wrong_use(
        "calibration: the rig's [arm] {} is another kind than its [nominal_arm] {}; take [arm] out of the "
        "file",
        rig.arm->model.name, rig.nominal_arm.name);
  CalibrationRecordings out;
  Steps steps{context, rig, plan, hooks, out};
  if (auto done = Course(steps, hooks).run(steps_for(context)); !done) return tl::unexpected(done.error());
  return out;
}

}  // namespace palpate::calibration::session
