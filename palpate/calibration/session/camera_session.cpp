#include "palpate/calibration/session/camera_session.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/hand_eye.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/marker_history.h"
#include "palpate/vision/camera.h"

namespace palpate::calibration::session {
namespace {

// The board looks the same after half a turn, and the detector numbers its corners from either end. Our board
// has a dark square outside its first corner and a light one outside its last: that tells the two apart.
std::vector<device::Pixel> numbered(std::vector<device::Pixel> corners, const vision::BoardShape& shape,
                                    const std::vector<std::uint8_t>& grey, int width, int height) {
  const auto brightness = [&](const device::Pixel& p) -> double {
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
  const device::Pixel first = at(0, 0) + 0.5 * (at(0, 0) - at(1, 1));
  const device::Pixel last =
      at(shape.columns - 1, shape.rows - 1) +
      0.5 * (at(shape.columns - 1, shape.rows - 1) - at(shape.columns - 2, shape.rows - 2));
  if (brightness(first) > brightness(last)) std::reverse(corners.begin(), corners.end());
  return corners;
}

}  // namespace

Expected<CameraDelay> CameraSession::lens_and_hand_eye() {
  const vision::BoardShape shape;
  std::vector<vision::BoardView> views;
  int width = 0, height = 0;
  auto record = record_views(context_, device::Gesture::look_around_board, plan_.board_s, plan_.board_every,
                             [&](const device::CameraImage& image) {
                               width = image.width;
                               height = image.height;
                               const auto grey = vision::grey_from_rgb(image.rgb);
                               const auto corners = vision::find_board_corners(grey, width, height, shape);
                               if (!corners) return false;
                               vision::BoardView view;
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
  std::vector<vision::BoardView> chosen;
  const std::size_t wanted = std::min(views.size(), static_cast<std::size_t>(plan_.lens_views));
  for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(views[i * views.size() / wanted]);
  auto lens = vision::calibrate_camera(chosen, width, height);
  if (!lens) return failed(lens);
  eye_.camera =
      rig::CameraCalibration{lens->value.model, lens->covariance,
                             provenance(plan_, views.front().name, "chessboard", lens->value.rms_px)};

  std::vector<device::StampedPose> hand, eye;
  for (const auto& pose : record->tracked)
    hand.push_back({pose.time_s, pose.marker.rotation, pose.marker.translation});
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto pose = vision::board_pose(lens->value.model, views[i]);
    if (!pose || pose->value.ambiguous) continue;
    const auto X_board_camera = pose->value.X_camera_board.inverse();
    eye.push_back({record->image_times_s[i], X_board_camera.rotation, X_board_camera.translation});
    recorded_.eye.push_back({record->image_times_s[i], X_board_camera});
  }
  HandEyeOptions options;
  options.estimate_delay = true;
  auto estimate = calibrate_hand_eye(hand, eye, options);
  if (!estimate) return failed(estimate);
  rig::HandEyeCalibration hand_eye;
  hand_eye.X_marker_camera = estimate->value.X_marker_camera;
  hand_eye.covariance = estimate->covariance.topLeftCorner<6, 6>();
  hand_eye.from = provenance(plan_, bytes_of(record->tracked), "hand-eye",
                             mm_from_metres(estimate->value.translation_rms));
  eye_.hand_eye = hand_eye;
  recorded_.lens_views = std::move(chosen);
  recorded_.hand = std::move(record->hand);
  return CameraDelay{-estimate->value.delay_s, estimate->value.delay_std_s};  // hand time = eye time + delay
}

Expected<Estimate<vision::LandmarkRefinement>> CameraSession::landmarks_from_pictures(
    const std::vector<rig::Landmark>& landmarks, double camera_after_tracker_s,
    const FindLandmarks& find_landmarks, const std::optional<rig::TouchNoise>& touch) {
  std::vector<device::CameraImage> images;
  constexpr int every = 3;  // neighbours say the same again
  auto record = record_views(context_, device::Gesture::look, plan_.look_s, every,
                             [&](const device::CameraImage& image) {
                               images.push_back(image);
                               return true;
                             });
  if (!record) return failed(record);
  device::MarkerHistory history(seconds(0.1), seconds(1e4));
  for (const auto& pose : record->tracked)
    history.add({Instant<GraphicsClock>::from_seconds(pose.time_s), pose.marker.rotation,
                 pose.marker.translation, pose.marker.covariance});
  std::vector<vision::LandmarkFrame> frames;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto marker =
        history.at(Instant<GraphicsClock>::from_seconds(record->image_times_s[i] - camera_after_tracker_s));
    if (!marker) continue;
    vision::LandmarkFrame frame;
    frame.X_world_marker = {marker->rotation, marker->translation};
    frame.covariance = marker->covariance;
    frame.sightings = find_landmarks(images[i], *eye_.camera,
                                     frame.X_world_marker * eye_.hand_eye->X_marker_camera, landmarks);
    frames.push_back(std::move(frame));
  }
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
