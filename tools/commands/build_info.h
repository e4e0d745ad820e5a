// What this program was made of. Its file is written at each build (cmake/build_info.cmake).
#pragma once

#include "palpate/core/build_info.h"

namespace palpate::tools::commands {

BuildInfo build_info();

}  // namespace palpate::tools::commands
