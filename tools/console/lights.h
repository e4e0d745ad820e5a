// How the parts of a system are doing, one light each: what somebody sees of it from across the room. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/transport/status.h"

namespace palpate::tools::console {

enum class Level { off, good, notice, warning, fault };  // off: nothing is known of it, or it is not used
std::string_view name_of(Level level);
Level level_of(device::Severity severity);

struct Light {
  std::string name;  // "arm"
  Level level = Level::off;
  std::string words;  // one line
};

// What is known of the system at a moment.
struct SystemView {
  bool server_answers = false;
  std::string trouble;  // why it does not, where that is known
  std::optional<transport::ServerStatus> status;
};

// servers, arm, forces, tracker, camera, clocks, recording: in this order, always all.
std::vector<Light> lights_of(const SystemView& view);

}  // namespace palpate::tools::console
