// Haply's Inverse3 through the maker's service on this machine (WebSocket).
//
// A thread of its own ("palpate-haply") talks with the service: drivers/arms/exchanged_arm.h says how.
//
// Frames: ArmBase is the arm's own axes (right-handed), which the service is asked for and tells. ArmSample::joints are the
// place of the cursor, m (ArmModel::Kind::cartesian); gimbal angles are those of a VerseGrip where there is one.
//
// A service that hears nothing of its client lets go of the arm. Refused at opening: a service that cannot be reached or
// has no such arm, with what to do.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/arms/exchanged_arm.h"
#include "palpate/core/json.h"
#include "palpate/web/web_socket_client.h"

namespace palpate::drivers::haply {

struct ArmSettings {
  std::string id;  // empty: the first arm that the service has
  web::WebSocketAddress service{"127.0.0.1", 10001, "/"};
  arms::LoopSettings loop{};
};

// "haply", "haply:ID", "haply:ID@HOST:PORT", "haply:@HOST:PORT"; nothing for other texts.
std::optional<ArmSettings> settings_of(std::string_view uri);

struct ArmStatus : arms::ExchangedArmStatus {
  std::uint64_t bad_states = 0;  // that the service told and that could not be read
};

class HaplyArm : public device::ArmDevice {
 public:
  // Returns once the arm has told its place, from an ordinary thread.
  static Expected<std::unique_ptr<HaplyArm>> open(const ArmSettings& settings);
  ~HaplyArm() override;  // no force, then the connection is closed

  // Stamped in the machine's monotonic clock.
  device::ArmSample read() override { return arm_->read(); }
  void command(const Vector3& force) override { arm_->command(force); }
  void let_go() noexcept override { arm_->let_go(); }

  ArmStatus status() const;
  const std::string& id() const;
  // What the service says of it: type, firmware, gravity compensation, force gate and so on. They change what is felt.
  Json config() const;

 private:
  struct Told;
  HaplyArm(std::unique_ptr<Told> told, std::unique_ptr<arms::ExchangedArm> arm);
  std::unique_ptr<Told> told_;  // by the service; the exchange writes to it
  std::unique_ptr<arms::ExchangedArm> arm_;
};

}  // namespace palpate::drivers::haply
