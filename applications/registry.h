// The applications of this program, each as it tells of itself. Read from any thread.
#pragma once

#include "palpate/scene/application_registry.h"

namespace palpate::applications {

const scene::ApplicationRegistry& registry();

}  // namespace palpate::applications
