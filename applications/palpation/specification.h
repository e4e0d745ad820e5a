// Palpation as it tells of itself to a registry.
#pragma once

#include "palpate/scene/application_registry.h"

namespace palpate::applications::palpation {

scene::ApplicationSpec specification();

}  // namespace palpate::applications::palpation
