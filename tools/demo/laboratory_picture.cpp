#include "tools/demo/laboratory_picture.h"

#include <array>
#include <utility>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/scene_view.h"
#include "palpate/core/text.h"
#include "palpate/render/outside_view.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/simulator.h"

namespace palpate::tools::demo {
namespace {

constexpr std::array<std::pair<std::string_view, LaboratoryView>, 5> kViews{
    {{"camera", LaboratoryView::camera},
     {"mono", LaboratoryView::mono},
     {"stereo", LaboratoryView::stereo},
     {"biocular", LaboratoryView::biocular},
     {"outside", LaboratoryView::outside}}};

}  // namespace

Expected<LaboratoryView> parse_view(std::string_view word) {
  for (const auto& [name, view] : kViews)
    if (name == word) return view;
  return wrong_use("--view '{}': camera, mono, stereo, biocular or outside is expected", excerpt(word));
}

LaboratoryPicture laboratory_picture(const sim::config::WorldFile& file, std::uint64_t seed,
                                     LaboratoryView view, render::Quality quality) {
  sim::Simulator world(file, seed);
  world.advance_to(world.now() + seconds(0.5));
  sim::TrueView left = world.true_view();
  left.board.reset();
  sim::TrueView right = left;
  right.X_world_camera.translation +=
      left.X_world_camera.rotation * Vector3(file.camera.stereo_baseline, 0.0, 0.0);
  right.noise_seed = left.noise_seed + 1;

  LaboratoryPicture picture{left.lens.width, left.lens.height, {}};
  sim::CameraRenderer camera;
  device::CameraImage left_image, right_image;
  for (auto* image : {&left_image, &right_image})
    image->width = left.lens.width, image->height = left.lens.height;
  camera.render(left, left_image.rgb);
  if (view == LaboratoryView::camera) {
    picture.rgb = std::move(left_image.rgb);
    return picture;
  }

  scene::SceneDescription scene;
  scene.ball_radius = file.ball.radius;
  scene.bat_radius = file.scene.bat_radius;
  scene.bat_offset = file.scene.bat_offset;
  const applications::pingpong::PingPongView scene_view(scene);
  const auto truth = world.true_state();
  scene::SceneState state;
  state.body_count = 2;
  state.bodies[applications::pingpong::kBat].set_p((truth.X_world_tip * Point<Tip>{scene.bat_offset}).m);
  state.bodies[applications::pingpong::kBat].set_q(truth.X_world_tip.rotation);
  // The ball has just touched the table, left of the middle.
  const Vector3 middle = 0.25 * (left.table[0] + left.table[1] + left.table[2] + left.table[3]);
  state.bodies[applications::pingpong::kBall].set_p(middle + Vector3(-0.10, file.ball.radius + 0.004, 0.05));
  auto items = scene_view.draw(state);
  render::RealScene real;
  real.surfaces = {{"table", left.table}, {"wall", left.wall}};
  real.marker_leds = left.marker_leds;
  real.arm =
      render::ArmConfiguration{left.X_world_base, left.lengths, left.theta, left.gimbal, left.X_tip_marker};
  real.arm_base_below = left.X_world_base.translation.y() - left.table[0].y();

  render::Compositor compositor(render::settings_of(quality));
  const render::PlayersCamera worn(left.lens, true);
  const render::Furniture furniture(left.table, render::settings_of(quality).light.lamp);
  std::vector<render::Viewpoint> eyes{{&left_image, left.lens, left.X_world_camera}};
  if (view == LaboratoryView::stereo) {
    camera.render(right, right_image.rgb);
    eyes.push_back({&right_image, right.lens, right.X_world_camera});
  } else if (view == LaboratoryView::outside) {
    eyes.front() = render::onlooker(left.table, picture.width, picture.height);
    for (const auto& item : worn.items(left.X_world_camera)) items.push_back(item);
    real.backdrop = furniture.items();
  }
  compositor.draw(eyes, items, real, picture.rgb);
  if (view == LaboratoryView::biocular)
    picture.rgb = render::biocular(picture.rgb, picture.width, picture.height);
  if (view == LaboratoryView::stereo || view == LaboratoryView::biocular) picture.width *= 2;
  return picture;
}

}  // namespace palpate::tools::demo
