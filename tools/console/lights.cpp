#include "tools/console/lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/transport/messages.h"

namespace palpate::tools::console {
namespace {

using device::ForceFault;
using device::ForceState;
using device::HealthCode;

// A picture at 60 Hz that is drawn with a clock wrong by more shows a fast ball 2 mm off.
constexpr double kSurelyAligned_us = 1000.0;

enum class Part { servers, tracker, camera, clocks, arm };

Part part_of(HealthCode code) {
  switch (code) {
    case HealthCode::camera_silent:
    case HealthCode::camera_unfit:
    case HealthCode::camera_lost:
    case HealthCode::recording_ended:
    case HealthCode::image_size:
    case HealthCode::landmarks_lost:
    case HealthCode::right_eye_lost:
    case HealthCode::board_lost:
      return Part::camera;
    case HealthCode::tracker_silent:
    case HealthCode::tracker_blind:
      return Part::tracker;
    case HealthCode::camera_clock:
    case HealthCode::tracker_clock:
      return Part::clocks;
    case HealthCode::arm_lost:
    case HealthCode::arm_inconsistent:
    case HealthCode::arm_uncalibrated:
    case HealthCode::arm_forces_off:
      return Part::arm;
    case HealthCode::laboratory_silent:
    case HealthCode::physics_server_gone:
    case HealthCode::other_scene:
    case HealthCode::other_rig:
      return Part::servers;
  }
  return Part::servers;
}

// The worse of the two stays; the first of equals.
void raise(Light& light, Level level, std::string words) {
  if (level <= light.level) return;
  light.level = level;
  light.words = std::move(words);
}

bool draws(const transport::ClientStatus& client) { return client.figures.frames > 0; }

void add_conditions(Light& light, Part part, const transport::ServerStatus& status) {
  for (const auto& client : status.clients)
    for (const auto& condition : client.figures.conditions)
      if (part_of(condition.code) == part)
        raise(light, level_of(device::severity_of(condition.code)),
              excerpt(condition.words, transport::kMaxConditionBytes));
}

const transport::LoopStatus* force_loop(const transport::ServerStatus& status) {
  for (const auto& loop : status.loops)
    if (loop.forces) return &loop;
  return nullptr;
}

Light servers_light(const SystemView& view) {
  Light light{"servers", Level::off, {}};
  if (!view.server_answers) {
    const std::string why = view.trouble.empty() ? "" : ": " + excerpt(view.trouble, 200);
    return {"servers", Level::fault, "no physics server answers" + why};
  }
  if (!view.status) return {"servers", Level::notice, "the physics server has not said yet how it is doing"};
  const auto drawing = std::count_if(view.status->clients.begin(), view.status->clients.end(), draws);
  raise(light, Level::good,
        fmt::format("{}, {}", excerpt(view.status->application, 64),
                    counted(static_cast<std::size_t>(drawing), "graphics server")));
  add_conditions(light, Part::servers, *view.status);
  return light;
}

bool of_the_arm(ForceFault fault) {
  return fault == ForceFault::bad_reading || fault == ForceFault::arm_silent ||
         fault == ForceFault::arm_lost || fault == ForceFault::arm_slow;
}

Light arm_light(const transport::LoopStatus& loop, const transport::ServerStatus& status) {
  Light light{"arm", Level::off, {}};
  if (of_the_arm(loop.forces->fault))
    raise(light, Level::fault, device::reason_text(*loop.forces));
  else if (loop.forces->fault == ForceFault::outside_workspace)
    raise(light, Level::notice, device::reason_text(*loop.forces));
  else
    raise(light, Level::good, fmt::format("read {:.0f} times a second", loop.rate_hz));
  add_conditions(light, Part::arm, status);
  return light;
}

Light forces_light(const transport::LoopStatus& loop, const transport::ServerStatus& status) {
  if (!status.failure.empty()) return {"forces", Level::fault, "off: " + excerpt(status.failure, 300)};
  const std::string words = excerpt(loop.forces_text(), 150);
  switch (loop.forces->state) {
    case ForceState::ready:
      return {"forces", Level::notice, words};
    case ForceState::running:
      return {"forces", Level::good, words};
    case ForceState::degraded:
      return {"forces", Level::warning, words};
    case ForceState::safe:
      break;
  }
  return {"forces", Level::fault, words};
}

// Tracker and camera: who has them tells of them.
Light device_light(std::string name, Part part, const transport::ServerStatus& status) {
  Light light{std::move(name), Level::off, "no graphics server looks at it"};
  if (std::any_of(status.clients.begin(), status.clients.end(), draws))
    raise(light, Level::good, "no complaint");
  add_conditions(light, part, status);
  return light;
}

Light clocks_light(const transport::ServerStatus& status) {
  Light light{"clocks", Level::off, "no graphics server compares its own"};
  double worst = -1.0;
  for (const auto& client : status.clients)
    if (draws(client)) worst = std::max(worst, client.figures.clock_uncertainty_us);
  if (worst >= 0.0)
    raise(light, worst > kSurelyAligned_us ? Level::warning : Level::good,
          fmt::format("known to {:.0f} us", std::ceil(worst)));
  add_conditions(light, Part::clocks, status);
  return light;
}

Light recording_light(const transport::ServerStatus& status) {
  const auto& recording = status.recording;
  if (!recording) return {"recording", Level::off, "the physics server records nothing"};
  if (recording->ended) return {"recording", Level::fault, "ended by an error of the disk"};
  if (recording->dropped > 0)
    return {"recording", Level::warning,
            fmt::format("{:.0f} s, {} lost", recording->seconds, counted(recording->dropped, "message"))};
  return {"recording", Level::good, fmt::format("{:.0f} s, nothing lost", recording->seconds)};
}

}  // namespace

Level level_of(device::Severity severity) {
  switch (severity) {
    case device::Severity::notice:
      return Level::notice;
    case device::Severity::warning:
      return Level::warning;
    case device::Severity::fault:
      return Level::fault;
  }
  return Level::fault;
}

std::string_view name_of(Level level) {
  switch (level) {
    case Level::off:
      return "off";
    case Level::good:
      return "good";
    case Level::notice:
      return "notice";
    case Level::warning:
      return "warning";
    case Level::fault:
      return "fault";
  }
  return "off";
}

std::vector<Light> lights_of(const SystemView& view) {
  std::vector<Light> lights{servers_light(view)};
  if (!view.server_answers || !view.status) {
    for (const char* name : {"arm", "forces", "tracker", "camera", "clocks", "recording"})
      lights.push_back({name, Level::off, "not known"});
    return lights;
  }
  const auto* loop = force_loop(*view.status);
  lights.push_back(loop ? arm_light(*loop, *view.status) : Light{"arm", Level::off, "there is none"});
  lights.push_back(loop ? forces_light(*loop, *view.status) : Light{"forces", Level::off, "there are none"});
  lights.push_back(device_light("tracker", Part::tracker, *view.status));
  lights.push_back(device_light("camera", Part::camera, *view.status));
  lights.push_back(clocks_light(*view.status));
  lights.push_back(recording_light(*view.status));
  return lights;
}

}  // namespace palpate::tools::console
