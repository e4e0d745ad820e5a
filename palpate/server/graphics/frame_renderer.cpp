#include "palpate/server/graphics/frame_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "palpate/core/text.h"
#include "palpate/math/looking.h"
#include "palpate/render/picture_file.h"
#include "palpate/render/picture_looks.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/vision/pose_refinement.h"
#include "palpate/vision/sightings.h"

namespace palpate::server::graphics {
namespace {

// Images in a row without the board after which nothing virtual is drawn any more: where would it stand?
constexpr int kLostForGood = 3;
// Another board is looked for at the second such image and then now and then: that takes as long as some
// images.
constexpr int kLookForOther = 2, kLookAgain = 90;

constexpr double kOutline = 0.0025;       // m, radius
constexpr double kRehearsedAbove = 0.05;  // m, over the table: whatever casts a shadow casts one
const Vector3 kRehearsedFrom(0.0, 0.4, 0.4);

rig::Rig with_corners(rig::Rig rig) {
  if (rig.board) rig.landmarks = vision::charuco_landmarks(rig.board->board, rig.board->X_world_board);
  return rig;
}

// Where the sightings are in the picture, whose lens is undone; those beyond its edges are not in it.
std::vector<FoundLandmark> found_landmarks(const device::CameraModel& lens,
                                           const std::vector<vision::Sighting>& sightings,
                                           const vision::RefinedPose& refined) {
  std::vector<FoundLandmark> found;
  for (const auto& sighting : sightings) {
    const auto place = lens.undistort_pixel(sighting.centre);
    if (!place || place->x() < 0 || place->y() < 0 || place->x() > lens.width - 1 ||
        place->y() > lens.height - 1)
      continue;
    const bool used =
        refined.refined && std::any_of(refined.used.begin(), refined.used.end(),
                                       [&](const auto& one) { return one.landmark == sighting.landmark; });
    found.push_back({*place, used});
  }
  return found;
}

scene::TriangleMesh outline_of(const std::vector<scene::SceneSurface>& surfaces) {
  scene::TriangleMesh mesh;
  for (const auto& surface : surfaces)
    for (std::size_t i = 0; i < 4; ++i)
      scene::append(mesh,
                    scene::cylinder_mesh(surface.corners[i], surface.corners[(i + 1) % 4], kOutline, 8));
  return mesh;
}

}  // namespace

bool has_body(const rig::ArmCalibration& arm) {
  return arm.model.kind == device::ArmModel::Kind::phantom && arm.model.name != rig::kMouseArm;
}

FrameRenderer::FrameRenderer(const rig::Rig& rig, const scene::SceneDescription& scene,
                             std::unique_ptr<scene::SceneView> scene_view, render::Quality quality)
    : left_{with_corners(rig), vision::overlay_knowledge(with_corners(rig))},
      scene_(scene),
      scene_view_(std::move(scene_view)),
      onlooker_(scene.surfaces, rig.camera->model.width, rig.camera->model.height),
      players_camera_(
          rig::has_two_eyes(rig)
              ? render::PlayersCamera(rig.camera->model, rig.right_camera->model, rig::right_in_left(rig))
              : render::PlayersCamera(rig.camera->model, !rig.board)) {
  set_quality(quality);
  if (!rig.board)
    furniture_.emplace(render::table_of(scene.surfaces).corners, picture_settings(rig, quality).light.lamp);
  auto objects = RealObjects::read(rig);
  if (!objects) throw std::invalid_argument(objects.error().message);
  objects_ = std::move(*objects);
  if (rig_.board) outline_ = outline_of(scene_.surfaces);
  if (!rig::has_two_eyes(rig)) return;
  rig::Rig right = rig::right_eye_rig(rig);
  vision::OverlayKnowledge known = vision::overlay_knowledge(right);
  right_ = {std::move(right), std::move(known)};
}

void FrameRenderer::set_quality(render::Quality quality) {
  auto& compositor = compositors_.at(static_cast<std::size_t>(quality));
  if (!compositor) compositor = std::make_unique<render::Compositor>(picture_settings(rig_, quality));
  compositor_ = compositor.get();
  compositor_->watch_stages(watcher_);
}

// As many bodies as a state can have over the middle of the table: a view draws more than are described.
void FrameRenderer::rehearse() {
  const auto& corners = render::table_of(scene_.surfaces).corners;
  const Vector3 place = 0.5 * (corners[0] + corners[2]) + kRehearsedAbove * Vector3::UnitY();
  device::CameraImage image;
  image.width = rig_.camera->model.width;
  image.height = rig_.camera->model.height;
  image.rgb.resize(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  FrameRecord record;
  record.X_world_camera = looking(place + kRehearsedFrom, place);
  record.have_state = true;
  record.state.tick = 1;
  record.state.body_count = scene::SceneState::kBodies;
  for (scene::BodyState& body : record.state.bodies) body.set_p(place);
  draw(image, nullptr, record);
}

void FrameRenderer::watch_stages(std::function<void(const char* stage)> watcher) {
  watcher_ = std::move(watcher);
  compositor_->watch_stages(watcher_);
}

Expected<void> FrameRenderer::find(const device::CameraImage& image,
                                   const std::optional<Pose<World, CameraOptical>>& near,
                                   FrameRecord& record) {
  const auto& [board, X_world_board] = *rig_.board;
  const auto grey = vision::grey_from_rgb(image.rgb);
  const auto sight = vision::find_charuco(grey, image.width, image.height, board);
  record.landmarks_predicted = board.corners();
  const auto pose = vision::camera_from_charuco(rig_.camera->model, board, X_world_board, sight, near);
  if (!pose) {
    if (sight.markers > 0)
      stranger_.reset();
    else if (lost_ % kLookAgain == kLookForOther - 1)
      stranger_ = vision::other_dictionary(grey, image.width, image.height, board.dictionary);
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
  const vision::OverlayPicture picture{
      {pose->X_world_camera, anywhere}, anywhere, *pose, vision::kCharucoCornerSd};
  if (const auto expected = vision::expected_overlay(left_.known, picture))
    record.expected_world_px = expected->total();
  return {};
}

void FrameRenderer::refine(EyeSide side, const device::CameraImage& image, const Matrix6& covariance,
                           EyePose& pose) {
  const auto& [rig, known] = side == EyeSide::left ? left_ : right_.value();
  const device::CameraModel& lens = rig.camera->model;
  vision::CameraPosePrior prior = vision::camera_from_marker(
      pose.X_world_camera * rig.hand_eye->X_marker_camera.inverse(), Matrix6::Zero(), *rig.hand_eye);
  prior.covariance += covariance;
  pose.landmarks_predicted = vision::predicted_landmarks(lens, prior.X_world_camera, rig.landmarks);
  const auto sightings = vision::find_sightings(image, *rig.camera, prior.X_world_camera, rig.landmarks);
  done("landmarks found");
  const vision::RefinementOptions options{.pixel_sd = vision::kUnstatedSightingSd};
  const vision::RefinedPose refined =
      vision::refine_camera_pose(lens, prior, known.landmarks, sightings, options);
  pose.landmarks_found = found_landmarks(lens, sightings, refined);
  pose.landmarks_used = refined.inliers;
  pose.landmarks_rejected = refined.outliers;
  pose.landmark_rms_px = refined.rms_px;
  pose.landmark_misfit = refined.misfit;
  pose.pose_covariance = refined.covariance;
  if (refined.refined) {
    pose.X_world_camera = refined.X_world_camera;
    pose.pose_source = PoseSource::refined;
  }
  done("pose refined");
  if (const auto expected = vision::expected_overlay(known, {prior, covariance, refined, options.pixel_sd}))
    pose.expected_world_px = expected->total();
  done("overlay estimated");
}

render::RealScene FrameRenderer::real_things(const FrameRecord& record) const {
  render::RealScene real;
  real.surfaces = scene_.surfaces;
  real.marker_leds = rig_.tip_marker_leds;
  real.bodies = objects_.bodies();
  real.hand = hand_;
  if (record.have_state && has_body(*rig_.arm)) {
    // The arm's joints are not sent: they follow from the stylus, which is.
    const auto& carried = record.state.bodies[scene::kCarried];
    const Point<World> tip{scene::shown_tip(record.state, scene_)};
    const auto X_base_world = rig_.arm->X_world_base.inverse();
    render::ArmConfiguration arm;
    arm.X_world_base = rig_.arm->X_world_base;
    arm.lengths = rig_.arm->model.lengths;
    if (device::phantom_inverse(X_base_world * tip, arm.lengths, arm.theta)) {
      arm.gimbal = device::phantom_gimbal(arm.theta, X_base_world.rotation * carried.q());
      arm.X_tip_marker.rotation = rig_.arm->R_tip_marker;
      arm.X_tip_marker.translation = -(rig_.arm->R_tip_marker * rig_.arm->tip_in_marker);
      real.arm = arm;
    }
  }
  return real;
}

std::vector<scene::DrawItem> FrameRenderer::virtual_things(const FrameRecord& record) const try {
  scene_view_->set_shape(record.shape);
  auto items = scene_view_->draw(record.state);
  scene::deform(items, record.shape);
  return items;
} catch (const std::exception& thrown) {
  throw std::runtime_error(
      fmt::format("the view of '{}' threw: {}", excerpt(scene_.application), one_line(thrown.what())));
}

std::optional<std::string> FrameRenderer::next_look() {
  const auto looks = scene_view_->looks();
  if (looks.size() < 2) return std::nullopt;
  look_ = (look_ + 1) % looks.size();
  scene_view_->set_look(look_);
  return looks[look_];
}

void FrameRenderer::draw_for_window() {
  look_ = scene_view_->look_at_window();
  scene_view_->set_look(look_);
}

bool FrameRenderer::lost() const { return rig_.board && lost_ >= kLostForGood; }

void FrameRenderer::draw(const device::CameraImage& image, const device::CameraImage* right,
                         FrameRecord& record) {
  // Nothing is known of the game yet: no picture is better than half of one.
  if (!record.have_state && !record.other_scene) return;
  render::RealScene real;
  std::vector<scene::DrawItem> items;
  if (record.have_state && !lost()) {
    real = real_things(record);
    items = virtual_things(record);
    if (!outline_.triangles.empty())
      items.push_back({&outline_, render::kHighlightLook, Quaternion::Identity(), Vector3::Zero(), false});
  }
  record.width = rig_.camera->model.width;
  record.height = rig_.camera->model.height;
  std::vector<render::Viewpoint> eyes{{&image, rig_.camera->model, record.X_world_camera}};
  if (right != nullptr && record.right)
    eyes.push_back({right, right_->rig.camera->model, record.right->X_world_camera});
  done("scene");
  compositor_->draw(eyes, items, real, record.rgb);
  if (record.two_eyes) {
    // While the right camera is silent both eyes see the same: nothing leaves its place, and nothing has
    // depth.
    if (eyes.size() == 1) record.rgb = render::biocular(record.rgb, record.width, record.height);
    record.width *= 2;
  }
  if (captions_shown_ && record.have_state)
    render::burn_captions(record.rgb, record.width, record.height, scene_view_->captions(record.state),
                          record.two_eyes ? 2 : 1);
  done("captions");
}

const render::OutsidePicture& FrameRenderer::outside(const FrameRecord& record) {
  if ((!record.have_state && !record.other_scene) || outside_.frame == record.number) return outside_;
  std::vector<scene::DrawItem> items;
  if (record.have_state) items = virtual_things(record);
  if (!lost())
    for (const auto& item : players_camera_.items(record.X_world_camera, record.right.has_value()))
      items.push_back(item);
  render::RealScene real = real_things(record);
  if (furniture_) real.backdrop = furniture_->items();
  outside_.frame = record.number;
  const render::Viewpoint& eye = onlooker_.viewpoint();
  outside_.width = eye.camera.width;
  outside_.height = eye.camera.height;
  compositor_->draw({&eye, 1}, items, real, outside_.rgb);
  return outside_;
}

}  // namespace palpate::server::graphics
