#include "palpate/system/picture_parts.h"

#include <stdexcept>

#include "palpate/calibration/pose_refinement.h"
#include "palpate/compositor/picture_file.h"
#include "palpate/system/lockstep_play.h"

namespace palpate {
namespace {

std::vector<Sighting> find_sightings(const CameraImage& image, const CameraCalibration& camera,
                                     const Pose<World, CameraOptical>& X_world_camera,
                                     const std::vector<Landmark>& landmarks) {
  std::vector<Sighting> sightings;
  for (const auto& seen :
       detect_landmarks(image, camera.model, X_world_camera, landmarks, {.encoding = camera.encoding}))
    sightings.push_back({seen.landmark, seen.centre, seen.covariance});
  return sightings;
}

// Images in a row without the board after which nothing virtual is drawn any more: where would it stand?
constexpr int kLostForGood = 3;
// Another board is looked for at the second such image and then now and then: that takes as long as some
// images.
constexpr int kLookForOther = 2, kLookAgain = 90;

constexpr double kOutline = 0.0025;  // m, radius

Rig with_corners(Rig rig) {
  if (rig.board) rig.landmarks = charuco_landmarks(rig.board->board, rig.board->X_world_board);
  return rig;
}

TriangleMesh outline_of(const std::vector<SceneSurface>& surfaces) {
  TriangleMesh mesh;
  for (const auto& surface : surfaces)
    for (std::size_t i = 0; i < 4; ++i)
      append(mesh, cylinder_mesh(surface.corners[i], surface.corners[(i + 1) % 4], kOutline, 8));
  return mesh;
}

}  // namespace

PictureParts::PictureParts(const Rig& rig, const SceneDescription& scene, std::unique_ptr<Artist> artist,
                           Quality quality)
    : left_{with_corners(rig), overlay_knowledge(with_corners(rig))},
      scene_(scene),
      artist_(std::move(artist)),
      compositor_(picture_settings(rig, quality)),
      outside_eye_(onlooker(scene.surfaces, rig.camera->model.width, rig.camera->model.height)),
      players_camera_(has_two_eyes(rig)
                          ? PlayersCamera(rig.camera->model, rig.right_camera->model, right_in_left(rig))
                          : PlayersCamera(rig.camera->model, !rig.board)) {
  if (!rig.board)
    furniture_.emplace(table_of(scene.surfaces).corners, picture_settings(rig, quality).light.lamp);
  auto objects = RealObjects::read(rig);
  if (!objects) throw std::invalid_argument(objects.error().message);
  objects_ = std::move(*objects);
  if (rig_.board) outline_ = outline_of(scene_.surfaces);
  if (!has_two_eyes(rig)) return;
  Rig right = right_eye_rig(rig);
  OverlayKnowledge known = overlay_knowledge(right);
  right_ = {std::move(right), std::move(known)};
}

PoseRefiner PictureParts::refiner() {
  return [this](EyeSide side, const CameraImage& image, const Matrix6& covariance, EyePose& pose) {
    refine(side == EyeSide::left ? left_ : right_.value(), image, covariance, pose);
  };
}

PoseFinder PictureParts::finder() {
  return [this](const CameraImage& image, const std::optional<Pose<World, CameraOptical>>& near,
                FrameRecord& record) { return find(image, near, record); };
}

Expected<void> PictureParts::find(const CameraImage& image,
                                  const std::optional<Pose<World, CameraOptical>>& near,
                                  FrameRecord& record) {
  const auto& [board, X_world_board] = *rig_.board;
  const auto grey = grey_from_rgb(image.rgb);
  const auto sight = find_charuco(grey, image.width, image.height, board);
  record.landmarks_predicted = board.corners();
  const auto pose = camera_from_charuco(rig_.camera->model, board, X_world_board, sight, near);
  if (!pose) {
    if (sight.markers > 0)
      stranger_.reset();
    else if (lost_ % kLookAgain == kLookForOther - 1)
      stranger_ = other_dictionary(grey, image.width, image.height, board.dictionary);
    ++lost_;
    if (stranger_)
      return refused(
          "the one in the picture has markers of dictionary {}, the rig file's has {}; put the rig "
          "file's board there, or make the rig anew: palpate rig webcam",
          *stranger_, board.dictionary);
    return tl::unexpected(pose.error());
  }
  lost_ = 0;
  stranger_.reset();
  record.landmarks_used = pose->inliers;
  record.landmarks_rejected = pose->outliers;
  record.landmark_rms_px = pose->rms_px;
  record.landmark_misfit = pose->misfit;
  record.pose_covariance = pose->covariance;
  record.X_world_camera = pose->X_world_camera;
  // Before the picture nothing was known of the pose.
  const Matrix6 anywhere = Matrix6::Identity();
  const OverlayPicture picture{{pose->X_world_camera, anywhere}, anywhere, *pose, kCharucoCornerSd};
  if (const auto expected = expected_overlay(left_.known, picture))
    record.expected_world_px = expected->total();
  return {};
}

FramePainter PictureParts::painter(bool captions) {
  return [this, captions](const CameraImage& image, const CameraImage* right, FrameRecord& record) {
    paint(image, right, record, captions);
  };
}

StatePredictor PictureParts::predictor() {
  return [this](const WorldState& state, Duration ahead) { return artist_->predict(state, ahead); };
}

void PictureParts::refine(const EyeParts& eye, const CameraImage& image, const Matrix6& covariance,
                          EyePose& pose) const {
  const auto& [rig, known] = eye;
  const CameraModel& lens = rig.camera->model;
  CameraPosePrior prior = camera_from_marker(pose.X_world_camera * rig.hand_eye->X_marker_camera.inverse(),
                                             Matrix6::Zero(), *rig.hand_eye);
  prior.covariance += covariance;
  pose.landmarks_predicted = predicted_landmarks(lens, prior.X_world_camera, rig.landmarks);
  const auto sightings = find_sightings(image, *rig.camera, prior.X_world_camera, rig.landmarks);
  const RefinementOptions options{.pixel_sd = kUnstatedSightingSd};
  const RefinedPose refined = refine_camera_pose(lens, prior, known.landmarks, sightings, options);
  pose.landmarks_used = refined.inliers;
  pose.landmarks_rejected = refined.outliers;
  pose.landmark_rms_px = refined.rms_px;
  pose.landmark_misfit = refined.misfit;
  pose.pose_covariance = refined.covariance;
  if (refined.refined) {
    pose.X_world_camera = refined.X_world_camera;
    pose.pose_source = PoseSource::refined;
  }
  if (const auto expected = expected_overlay(known, {prior, covariance, refined, options.pixel_sd}))
    pose.expected_world_px = expected->total();
}

RealScene PictureParts::real_things(const FrameRecord& record) const {
  RealScene real;
  real.surfaces = scene_.surfaces;
  real.marker_leds = rig_.tip_marker_leds;
  real.bodies = objects_.bodies();
  if (record.have_state && rig_.arm->model != kMouseArm) {
    // The arm's joints are not sent: they follow from the stylus, which is.
    const auto& bat = record.state.bodies[1];
    const Point<World> tip{shown_tip(record.state, scene_)};
    const auto X_base_world = rig_.arm->X_world_base.inverse();
    draw::ArmConfiguration arm;
    arm.X_world_base = rig_.arm->X_world_base;
    arm.lengths = rig_.arm->lengths;
    if (phantom_inverse(X_base_world * tip, arm.lengths, arm.theta)) {
      arm.gimbal = phantom_gimbal(arm.theta, X_base_world.rotation * bat.q());
      arm.X_tip_marker.rotation = rig_.arm->R_tip_marker;
      arm.X_tip_marker.translation = -(rig_.arm->R_tip_marker * rig_.arm->tip_in_marker);
      real.arm = arm;
    }
  }
  return real;
}

bool PictureParts::lost() const { return rig_.board && lost_ >= kLostForGood; }

void PictureParts::paint(const CameraImage& image, const CameraImage* right, FrameRecord& record,
                         bool captions) {
  if (!record.have_state) return;  // nothing is known of the game yet: no picture is better than half of one
  RealScene real = real_things(record);
  auto items = record.have_state ? artist_->draw(record.state) : std::vector<DrawItem>{};
  if (!outline_.triangles.empty())
    items.push_back({&outline_, Material::highlight, Quaternion::Identity(), Vector3::Zero(), false});
  if (lost()) {
    items.clear();
    real = {};
  }
  record.width = rig_.camera->model.width;
  record.height = rig_.camera->model.height;
  std::vector<Eye> eyes{{&image, rig_.camera->model, record.X_world_camera}};
  if (right != nullptr && record.right)
    eyes.push_back({right, right_->rig.camera->model, record.right->X_world_camera});
  compositor_.draw(eyes, items, real, record.rgb);
  if (record.two_eyes) {
    // While the right camera is silent both eyes see the same: nothing leaves its place, and nothing has
    // depth.
    if (eyes.size() == 1) record.rgb = biocular(record.rgb, record.width, record.height);
    record.width *= 2;
  }
  if (captions)
    burn_captions(record.rgb, record.width, record.height, artist_->captions(record.state),
                  record.two_eyes ? 2 : 1);
}

const OutsidePicture& PictureParts::outside(const FrameRecord& record) {
  if (!record.have_state || outside_.frame == record.number) return outside_;
  auto items = artist_->draw(record.state);
  if (!lost())
    for (const auto& item : players_camera_.items(record.X_world_camera, record.right.has_value()))
      items.push_back(item);
  RealScene real = real_things(record);
  if (furniture_) real.backdrop = furniture_->items();
  outside_.frame = record.number;
  outside_.width = outside_eye_.camera.width;
  outside_.height = outside_eye_.camera.height;
  compositor_.draw({&outside_eye_, 1}, items, real, outside_.rgb);
  return outside_;
}

FindLandmarks landmark_finder() { return find_sightings; }

}  // namespace palpate
