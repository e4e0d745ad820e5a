#include <fmt/format.h>

#include "applications/scene_settings.h"
#include "applications/touched_mesh.h"
#include "palpate/core/text.h"
#include "palpate/render/picture_file.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/demo/laboratory_picture.h"

namespace palpate::tools::commands {

void add_picture(CLI::App& program) {
  auto* command = program.add_subcommand(
      "picture",
      "One picture of the simulated laboratory, from the truth: views and quality levels to look at");
  struct Options {
    std::string view = "mono", quality = "medium", application = "pingpong", world, out = "picture.png";
    std::uint64_t seed = 1;
  };
  auto options = std::make_shared<Options>();
  command
      ->add_option("--view", options->view,
                   "camera (its lens not undone), mono, stereo (two cameras side by side), biocular (one "
                   "camera for both eyes) or outside")
      ->capture_default_str();
  command->add_option("--quality", options->quality, "low, medium or high")->capture_default_str();
  command->add_option("--app", options->application, "Application; `palpate apps` lists them")
      ->capture_default_str();
  command->add_option("--world", options->world, "World file; the reference laboratory where none is named");
  command->add_option("--seed", options->seed, "Draws the laboratory's imperfections")->capture_default_str();
  command->add_option("--out", options->out, "PNG file; - = standard output")->capture_default_str();
  on(command, [options]() -> Expected<void> {
    if (!options->out.ends_with(".png") && options->out != "-")
      return wrong_use(
          "--out '{}': PNG is what is written; a file name that ends in .png is expected, or - for standard "
          "output",
          excerpt(options->out, 200));
    const auto view = demo::parse_view(options->view);
    if (!view) return tl::unexpected(view.error());
    const auto quality = render::parse_quality(options->quality);
    if (!quality) return tl::unexpected(quality.error());
    sim::config::WorldFile world = sim::config::reference_world();
    if (!options->world.empty()) {
      auto read = sim::config::read_world(options->world);
      if (!read) return tl::unexpected(read.error());
      world = *read;
    }
    const auto all = known_applications();
    if (all.find(options->application) == nullptr)
      return wrong_use("--app {}: not known; `palpate apps` lists the applications there are",
                       excerpt(options->application));
    auto scene = applications::scene_settings(world, options->application);
    if (auto mesh = applications::read_touched_mesh(scene); !mesh) return tl::unexpected(mesh.error());
    const auto picture =
        demo::laboratory_picture(world, options->seed, all, std::move(scene), *view, *quality);
    if (!picture) return tl::unexpected(picture.error());
    return render::write_png(options->out, picture->rgb, picture->width, picture->height);
  });
}

}  // namespace palpate::tools::commands
