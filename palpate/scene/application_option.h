// An option of the command line that an application brings, such as `--mesh FILE`: a short way to some of its
// settings. The commands that take settings (physics, demo) offer it beside their own options.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/scene/setting_schema.h"

namespace palpate::scene {

struct ApplicationOption {
  std::string name;                       // "--mesh"; two applications may have one of the same name
  std::string help;                       // what it does, in one sentence without a full stop
  std::vector<std::string> choices = {};  // what may be said; empty: anything
  // Puts what was said over the settings of the application that runs. Wrong use for what cannot be.
  std::function<Expected<void>(const std::string& said, SettingValues& values)> apply;
};

}  // namespace palpate::scene
