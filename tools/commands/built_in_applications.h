// The applications that this program was built with: those that cmake/layers.cmake lists.
#pragma once

#include "palpate/scene/application_registry.h"

namespace palpate::tools::commands {

// Throws std::invalid_argument where one of them cannot be used (ApplicationRegistry::add).
scene::ApplicationRegistry built_in_applications();

}  // namespace palpate::tools::commands
