// One picture of the simulated laboratory with an application's virtual objects in it, drawn from the truth: to see
// what views, quality levels and a world file look like, and for documents.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/render/compositor.h"
#include "palpate/scene/application_registry.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::tools::demo {

// camera: what the camera sees, its lens not undone. mono: the augmented picture. stereo: two cameras, the
// world file's stereo_baseline apart, side by side. biocular: one camera's picture twice. outside: from the
// side, the player's camera included (outside_view.h).
enum class LaboratoryView : std::uint8_t { camera, mono, stereo, biocular, outside };
Expected<LaboratoryView> parse_view(std::string_view word);

struct LaboratoryPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

// `scene`: the application's settings; its surfaces are the laboratory's. Throws where no OpenGL is to be had.
Expected<LaboratoryPicture> laboratory_picture(const sim::config::WorldFile& world, std::uint64_t seed,
                                               const scene::ApplicationRegistry& applications,
                                               scene::SceneDescription scene, LaboratoryView view,
                                               render::Quality quality);

}  // namespace palpate::tools::demo
