#include "tools/demo/laboratory_picture.h"

#include <array>
#include <utility>

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

device::CameraImage image_of(sim::CameraRenderer& camera, const sim::TrueView& view) {
  device::CameraImage image;
  image.width = view.lens.width;
  image.height = view.lens.height;
  camera.render(view, image.rgb);
  return image;
}

// The second camera, as far to the right as the world file says.
sim::TrueView beside(const sim::TrueView& left, double baseline) {
  sim::TrueView right = left;
  right.X_world_camera.translation += left.X_world_camera.rotation * Vector3(baseline, 0.0, 0.0);
  right.noise_seed = left.noise_seed + 1;
  return right;
}

render::RealScene real_scene(const sim::TrueView& seen) {
  render::RealScene real;
  real.surfaces = {{"table", seen.table}, {"wall", seen.wall}};
  real.marker_leds = seen.marker_leds;
  real.hand = seen.hand.side;
  real.arm =
      render::ArmConfiguration{seen.X_world_base, seen.lengths, seen.theta, seen.gimbal, seen.X_tip_marker};
  real.arm_base_below = seen.X_world_base.translation.y() - seen.table[0].y();
  return real;
}

}  // namespace

Expected<LaboratoryView> parse_view(std::string_view word) {
  for (const auto& [name, view] : kViews)
    if (name == word) return view;
  return wrong_use("--view '{}': camera, mono, stereo, biocular or outside is expected", excerpt(word));
}

Expected<LaboratoryPicture> laboratory_picture(const sim::config::WorldFile& file, std::uint64_t seed,
                                               const scene::ApplicationRegistry& applications,
                                               scene::SceneDescription scene, LaboratoryView view,
                                               render::Quality quality) {
  sim::Simulator world(file, seed);
  world.advance_to(world.now() + seconds(0.5));
  sim::TrueView left = world.true_view();
  left.board.reset();
  LaboratoryPicture picture{left.lens.width, left.lens.height, {}};
  sim::CameraRenderer camera;
  device::CameraImage left_image = image_of(camera, left), right_image;
  if (view == LaboratoryView::camera) {
    picture.rgb = std::move(left_image.rgb);
    return picture;
  }

  scene.surfaces = {{"table", left.table}, {"wall", left.wall}};
  const auto scene_view = applications.make_view(scene);
  if (!scene_view) return tl::unexpected(scene_view.error());
  const auto state = applications.example_state(scene, world.true_state().X_world_tip);
  if (!state) return tl::unexpected(state.error());
  const auto shape = applications.example_shape(scene, *state);
  if (!shape) return tl::unexpected(shape.error());
  (*scene_view)->set_shape(*shape);
  auto items = (*scene_view)->draw(*state);
  scene::deform(items, *shape);
  render::RealScene real = real_scene(left);

  render::Compositor compositor(render::settings_of(quality));
  const render::PlayersCamera worn(left.lens, true);
  const render::Furniture furniture(left.table, render::settings_of(quality).light.lamp);
  std::vector<render::Viewpoint> eyes{{&left_image, left.lens, left.X_world_camera}};
  if (view == LaboratoryView::stereo) {
    const sim::TrueView right = beside(left, file.camera.stereo_baseline);
    right_image = image_of(camera, right);
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
