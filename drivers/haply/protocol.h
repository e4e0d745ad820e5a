// What Haply's Inverse service says and is told, as text (JSON) and as values: pure functions, no sockets.
//
// The service answers each message of its client with the state of all devices; the first thing it says after a connection
// also holds their configuration. Places, velocities and forces are in the service's "application space", which is the
// arm's own right-handed axes where basis and mount are as hello() sets them (configured() tells); metres, newtons, unit
// quaternions. Fields that are not read here are passed over. Errors: refused, with what was expected. Source:
// docs.haply.co, Inverse SDK 3.5 (WebSocket protocol, control commands, device configuration, JSON conventions).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/math/so3.h"

namespace palpate::drivers::haply {

inline constexpr std::uint16_t kDefaultPort = 10001;

struct ArmState {
  std::string id;                           // "049D"
  Vector3 place = Vector3::Zero();          // m, of the cursor
  std::optional<Vector3> force;             // N, what the service says that the arm gives
  std::optional<bool> calibrated, powered;  // where the service tells
  Json config;                              // as the service has it; null where it does not tell
};
// A handle that knows how it is turned.
struct GripState {
  std::string id;
  Quaternion orientation = Quaternion::Identity();
  std::uint32_t buttons = 0;  // a is bit 0, b bit 1, c bit 2
};
struct ServiceState {
  std::vector<ArmState> arms;
  std::vector<GripState> grips;  // those with a cable first
};

// Refused: no JSON, devices without an id, places and turns that are none.
Expected<ServiceState> read_state(std::string_view text);

// The first message: who we are, no change of axes, and the request to tell the configuration again.
std::string hello(const std::string& arm);
// Refused: axes or mount are not those that hello() asked for.
Expected<void> check_configured(const ArmState& arm);
// N, axes of the arm. Said to both names that versions 3.1 to 3.5 know for it; unknown names are passed over by the service.
std::string force_command(const std::string& arm, const Vector3& force);

}  // namespace palpate::drivers::haply
