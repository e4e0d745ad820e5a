#include "palpate/calibration/session/camera_session.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/hand_eye.h"
#include "palpate/calibration/session/board_views.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/vision/camera.h"

namespace palpate::calibration::session {

Expected<CameraDelay> CameraSession::lens_and_hand_eye() {
  auto seen = record_board_views(context_, plan_.board_s, plan_.board_every);
  if (!seen) return failed(seen);
  const auto& views = seen->views;
  constexpr std::size_t kFewest = 12;
  if (views.size() < kFewest)
    return refused(
        "camera: the board was found in {}, at least {} are needed; keep all of it in view, in good "
        "light",
        counted(views.size(), "image"), kFewest);
  // Views spread evenly over the movement.
  std::vector<vision::BoardView> chosen;
  const std::size_t wanted = std::min(views.size(), static_cast<std::size_t>(plan_.lens_views));
  for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(views[i * views.size() / wanted]);
  auto lens = vision::calibrate_camera(chosen, seen->width, seen->height, {.lens = plan_.lens});
  if (!lens) return failed(lens);
  eye_.camera =
      rig::CameraCalibration{lens->value.model, lens->covariance,
                             provenance(plan_, views.front().name, "chessboard", lens->value.rms_px)};

  std::vector<device::StampedPose> hand, eye;
  for (const auto& pose : seen->record.tracked)
    hand.push_back({pose.time_s, pose.marker.rotation, pose.marker.translation});
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto pose = vision::board_pose(lens->value.model, views[i]);
    if (!pose || pose->value.ambiguous) continue;
    const auto X_board_camera = pose->value.X_camera_board.inverse();
    eye.push_back({seen->record.image_times_s[i], X_board_camera.rotation, X_board_camera.translation});
    recorded_.eye.push_back({seen->record.image_times_s[i], X_board_camera});
  }
  HandEyeOptions options;
  options.estimate_delay = true;
  auto estimate = calibrate_hand_eye(hand, eye, options);
  if (!estimate) return failed(estimate);
  rig::HandEyeCalibration hand_eye;
  hand_eye.X_marker_camera = estimate->value.X_marker_camera;
  hand_eye.covariance = estimate->covariance.topLeftCorner<6, 6>();
  hand_eye.from = provenance(plan_, bytes_of(seen->record.tracked), "hand-eye",
                             mm_from_metres(estimate->value.translation_rms));
  eye_.hand_eye = hand_eye;
  recorded_.lens_views = std::move(chosen);
  recorded_.hand = std::move(seen->record.hand);
  return CameraDelay{-estimate->value.delay_s, estimate->value.delay_std_s};  // hand time = eye time + delay
}

Expected<Estimate<vision::LandmarkRefinement>> CameraSession::landmarks_from_pictures(
    const std::vector<rig::Landmark>& landmarks, double camera_after_tracker_s,
    const FindLandmarks& find_landmarks, const std::optional<rig::TouchNoise>& touch) {
  const auto tracked = record_landmark_frames(
      context_, *eye_.camera, *eye_.hand_eye, landmarks,
      {.seconds = plan_.look_s, .camera_after_tracker_s = camera_after_tracker_s}, find_landmarks);
  if (!tracked) return failed(tracked);
  std::vector<vision::LandmarkFrame> frames;
  for (const auto& one : *tracked) frames.push_back(one.frame);
  auto refined = vision::refine_landmarks(*eye_.camera, *eye_.hand_eye, landmarks, frames,
                                          {.pixel_sd = vision::kUnstatedSightingSd, .touch = touch});
  if (!refined) return failed(refined);
  eye_.camera->model = refined->value.camera.model;
  eye_.camera->covariance = refined->value.camera.covariance;
  eye_.hand_eye->X_marker_camera = refined->value.hand_eye.X_marker_camera;
  eye_.hand_eye->covariance = refined->value.hand_eye.covariance;
  recorded_.landmark_rms_px_before = refined->value.rms_px_before;
  recorded_.landmark_rms_px = refined->value.rms_px;
  return refined;
}

}  // namespace palpate::calibration::session
