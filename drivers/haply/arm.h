// Haply's Inverse3 through the maker's service on this machine (WebSocket).
//
// A thread of this object ("palpate-haply") talks with the service: it says a force and hears a state, a thousand times a
// second, and connects again by itself. The haptic loop never waits for it: read() takes the newest sample and command()
// leaves the newest force, through mailboxes without locks. A force reaches the arm up to one exchange later.
//
// Frames: ArmBase is the arm's own axes (right-handed), which the service is asked for and tells. ArmSample::joints are the
// place of the cursor, m (ArmModel::Kind::cartesian); gimbal angles are those of a VerseGrip where there is one.
//
// What can go wrong is a state, told by status(). While there is no fresh sample read() gives places that are not numbers,
// at which the haptic loop fades its forces; while there is no fresh command this object fades them itself, and a service
// that hears nothing of its client lets go of the arm. Refused at opening: a service that cannot be reached or has no such
// arm, with what to do.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/core/json.h"
#include "palpate/device/devices.h"
#include "palpate/device/health.h"
#include "palpate/web/web_socket_client.h"

namespace palpate::drivers::haply {

struct ArmSettings {
  std::string id;  // empty: the first arm that the service has
  web::WebSocketAddress service{"127.0.0.1", 10001, "/"};
  // Samples and commands older than this do not count, s.
  double watchdog_s = 0.005;
  double fade_s = 0.020;  // from the full command to none where it is stale
  double ramp_s = 1.0;  // from none to the full command, at the start and after an outage that was not brief
};

// "haply", "haply:ID", "haply:ID@HOST:PORT", "haply:@HOST:PORT"; nothing for other texts.
std::optional<ArmSettings> settings_of(std::string_view uri);

struct ArmStatus {
  // arm_lost, arm_uncalibrated or arm_forces_off, with the reason and what to do; none: it runs.
  std::optional<device::HealthReport> health;
  std::uint64_t exchanges = 0, stale_exchanges = 0, refused_commands = 0, bad_states = 0, times_lost = 0;
  double round_trip_s = 0.0;  // mean of the last second or so
};

class HaplyArm : public device::ArmDevice {
 public:
  // Returns once the arm has told its place, from an ordinary thread.
  static Expected<std::unique_ptr<HaplyArm>> open(const ArmSettings& settings);
  ~HaplyArm() override;  // no force, then the connection is closed

  // Stamped in the machine's monotonic clock.
  device::ArmSample read() override;
  void command(const Vector3& force) override;
  void let_go() noexcept override;

  ArmStatus status() const;
  const std::string& id() const;
  // What the service says of it: type, firmware, gravity compensation, force gate and so on. They change what is felt.
  Json config() const;

 private:
  class Connection;
  explicit HaplyArm(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace palpate::drivers::haply
