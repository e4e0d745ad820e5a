#include "palpate/sim/internal/arm_picture.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>

#include "palpate/render/projection.h"
#include "palpate/sim/internal/camera_shaders.h"
#include "palpate/sim/internal/picture_tiles.h"
#include "palpate/sim/lens_rays.h"

namespace palpate::sim {
namespace {

constexpr double kLayerScale = 1.1;  // the arm is drawn this much finer than the camera sees, then bent

// Of each ArmLook: colour; how much it mirrors straight on, at the edge, the lamp; light of its own.
const std::vector<render::Vector3f> kArmLooks = {
    {0.022f, 0.022f, 0.023f}, {0.04f, 0.30f, 0.10f}, {0, 0, 0},              // black
    {0.16f, 0.165f, 0.175f},  {0.45f, 0.40f, 0.75f}, {0, 0, 0},              // metal
    {0.055f, 0.057f, 0.062f}, {0.12f, 0.35f, 0.25f}, {0, 0, 0},              // dark
    {0.70f, 0.70f, 0.70f},    {0.02f, 0.05f, 0.05f}, {0, 0, 0},              // bright
    {0.10f, 0.01f, 0.01f},    {0.02f, 0.00f, 0.50f}, {0.55f, 0.05f, 0.04f},  // red
    {0.42f, 0.22f, 0.15f},    {0.01f, 0.06f, 0.03f}, {0, 0, 0}};             // skin

}  // namespace

ArmPicture::ArmPicture()
    : arm_("sim/arm", kArmVertex,
           render::kLightGlsl + render::encoding_glsl(device::Encoding::root) + kArmFragment),
      through_lens_("sim/layer", render::kFullScreen, layer_shader()) {}

void ArmPicture::prepare(const device::CameraModel& lens, const Eigen::Vector2d& low,
                         const Eigen::Vector2d& high) {
  ray_low_ = low;
  ray_high_ = high;
  camera_ = {};
  camera_.fx = kLayerScale * lens.fx;
  camera_.fy = kLayerScale * lens.fy;
  camera_.cx = 2.0 - camera_.fx * low.x();
  camera_.cy = 2.0 - camera_.fy * low.y();
  camera_.width = static_cast<int>(std::ceil(camera_.fx * (high.x() - low.x()))) + 4;
  camera_.height = static_cast<int>(std::ceil(camera_.fy * (high.y() - low.y()))) + 4;
  layer_ = render::Target(camera_.width, camera_.height, render::Format::rgba8, true, 4);
}

void ArmPicture::draw(const render::ArmBody& body, const TrueView& view, const device::RoomLight& light,
                      float falloff, const render::Target& picture, const render::FullScreen& screen) {
  const Pose<CameraOptical, World> X = view.X_world_camera.inverse();
  Eigen::Vector2d low = ray_high_, high = ray_low_;
  bool everywhere = false;
  const auto take = [&](const Vector3& world) {
    const Vector3 p = (X * Point<World>{world}).m;
    if (p.z() < 0.06) everywhere = true;
    const Eigen::Vector2d n = p.head<2>() / std::max(p.z(), 0.06);
    low = low.cwiseMin(n);
    high = high.cwiseMax(n);
  };
  for (const auto& vertex : body.vertices()) take(render::Vector3f(vertex.position).cast<double>());
  if (everywhere) low = ray_low_, high = ray_high_;
  const int left = std::max(0, static_cast<int>(camera_.fx * low.x() + camera_.cx) - 3);
  const int above = std::max(0, static_cast<int>(camera_.fy * low.y() + camera_.cy) - 3);
  const int right = std::min(camera_.width, static_cast<int>(camera_.fx * high.x() + camera_.cx) + 4);
  const int below = std::min(camera_.height, static_cast<int>(camera_.fy * high.y() + camera_.cy) + 4);
  if (right <= left || below <= above) return;

  layer_.bind();
  scissor({left, above, right - left, below - above});
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  arm_.use()
      .set("to_clip", render::Matrix4f(render::projection_matrix(camera_, 0.05, 8.0) * render::matrix4(X)))
      .set("eye", render::Vector3f(view.X_world_camera.translation.cast<float>()));
  render::set_light(arm_, light);
  arm_.set("looks", kArmLooks);
  glEnable(GL_CULL_FACE);
  glFrontFace(GL_CW);  // row 0 on top mirrors the window
  body.mesh().draw();
  glFrontFace(GL_CCW);
  glDisable(GL_CULL_FACE);
  glDisable(GL_DEPTH_TEST);
  layer_.resolve(left, above, right - left, below - above);

  picture.bind();
  glDisable(GL_SCISSOR_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  through_lens_.use().set("rays", 0).set("falloff", falloff);
  layer_.texture().bind(3);
  const double w = camera_.width, h = camera_.height;
  through_lens_.set("layer", 3)
      .set("to_layer", render::Vector4f(Eigen::Vector4d((camera_.cx + 0.5) / w, (camera_.cy + 0.5) / h,
                                                        camera_.fx / w, camera_.fy / h)
                                            .cast<float>()));
  through_lens_.set("used", render::Vector4f(Eigen::Vector4d((left + 0.5) / w, (above + 0.5) / h,
                                                             (right - 0.5) / w, (below - 0.5) / h)
                                                 .cast<float>()));
  // Only where the layer holds something: its box, bent through the lens.
  const auto corner = [&](int x, int y) {
    return Vector3((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1.0);
  };
  if (scissor(pixel_box(view.lens, {corner(left, above), corner(right, above), corner(right, below),
                                    corner(left, below)}))) {
    screen.draw();
  }
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
}

}  // namespace palpate::sim
