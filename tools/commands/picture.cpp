#include <fmt/format.h>

#include "palpate/core/text.h"
#include "palpate/render/picture_file.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/sim/config/world_scene.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/commands/settings_options.h"
#include "tools/demo/laboratory_picture.h"

namespace palpate::tools::commands {
namespace {

struct PictureOptions {
  std::string view = "mono", quality = "medium", application, world, out = "picture.png";
  SettingsOptions settings;
  std::uint64_t seed = 1;
};

Expected<void> draw_picture(const PictureOptions& options) {
  if (!options.out.ends_with(".png") && options.out != "-")
    return wrong_use(
        "--out '{}': PNG is what is written; a file name that ends in .png is expected, or - for standard "
        "output",
        excerpt(options.out, 200));
  const auto view = demo::parse_view(options.view);
  if (!view) return tl::unexpected(view.error());
  const auto quality = render::parse_quality(options.quality);
  if (!quality) return tl::unexpected(quality.error());
  const auto all = known_applications();
  auto world = world_of(options.world, all);
  if (!world) return tl::unexpected(world.error());
  if (auto ok = apply(options.settings, all, options.application, world->settings); !ok) return ok;
  auto scene = sim::config::scene_of(*world, all, options.application);
  if (!scene) return tl::unexpected(scene.error());
  if (auto mesh = scene::read_mesh_asset(*scene); !mesh) return tl::unexpected(mesh.error());
  const auto picture =
      demo::laboratory_picture(*world, options.seed, all, std::move(*scene), *view, *quality);
  if (!picture) return tl::unexpected(picture.error());
  return render::write_png(options.out, picture->rgb, picture->width, picture->height);
}

}  // namespace

void add_picture(CLI::App& program) {
  auto* command = program.add_subcommand(
      "picture",
      "One picture of the simulated laboratory, from the truth: views and quality levels to look at");
  auto options = std::make_shared<PictureOptions>();
  command
      ->add_option("--view", options->view,
                   "camera (its lens not undone), mono, stereo (two cameras side by side), biocular (one "
                   "camera for both eyes) or outside")
      ->capture_default_str();
  command->add_option("--quality", options->quality, "low, medium or high")->capture_default_str();
  add_application_option(*command, options->application);
  add_settings_options(*command, options->settings, known_applications());
  command->add_option("--world", options->world, "World file; the reference laboratory where none is named");
  command->add_option("--seed", options->seed, "Draws the laboratory's imperfections")->capture_default_str();
  command->add_option("--out", options->out, "PNG file; - = standard output")->capture_default_str();
  on(command, [options] { return draw_picture(*options); });
}

}  // namespace palpate::tools::commands
