// The application jelly as it tells of itself to a registry.
#pragma once

#include "palpate/scene/application_registry.h"

namespace jelly {

palpate::scene::ApplicationSpec specification();

}  // namespace jelly
