#include "drivers/forcedimension/driver.h"

#include <fmt/format.h>

#include "drivers/arms/requests.h"
#include "drivers/forcedimension/arm.h"

namespace palpate::drivers::forcedimension {
namespace {

class OpenedForceDimensionArm : public device::OpenedArm {
 public:
  explicit OpenedForceDimensionArm(std::unique_ptr<ForceDimensionArm> arm) : arm_(std::move(arm)) {}
  device::ArmDevice& device() override { return *arm_; }

  device::ArmFacts facts() const override {
    device::ArmFacts facts;
    facts.identity = fmt::format("forcedimension {} {}", arm_->facts().model, arm_->facts().serial);
    facts.states_place = true;
    facts.peak_n = arm_->facts().peak_n;
    return facts;
  }
  // A real arm is worth waiting for: it never ends the server.
  std::optional<device::HealthReport> health() override { return arm_->status().health; }

  std::string description() const override {
    const auto& facts = arm_->facts();
    return fmt::format("arm forcedimension: {} (serial {}, {:.1f} N{}), SDK {}, {}", facts.model,
                       facts.serial, facts.peak_n, facts.watchdog ? "" : ", without a watchdog of its own",
                       facts.library_version, facts.library);
  }

  Json figures() const override {
    const auto status = arm_->status();
    const auto& facts = arm_->facts();
    return {{"driver", "forcedimension"},
            {"model", facts.model},
            {"serial", facts.serial},
            {"library", facts.library},
            {"library_version", facts.library_version},
            {"peak_n", facts.peak_n},
            {"wrist", facts.wrist},
            {"left_handed", facts.left_handed},
            {"watchdog", facts.watchdog},
            {"exchanges", status.exchanges},
            {"round_trip_us", 1e6 * status.round_trip_s},
            {"stale_exchanges", status.stale_exchanges},
            {"refused_commands", status.refused_commands},
            {"saturations", arm_->saturations()},
            {"times_lost", status.times_lost}};
  }

 private:
  std::unique_ptr<ForceDimensionArm> arm_;
};

Expected<std::unique_ptr<device::OpenedArm>> open_arm(const device::ArmRequest& request) {
  if (auto fine = arms::check_states_place(request); !fine) return tl::unexpected(fine.error());
  auto arm = ForceDimensionArm::open(*settings_of(request.uri));
  if (!arm) return tl::unexpected(arm.error());
  return std::make_unique<OpenedForceDimensionArm>(std::move(*arm));
}

}  // namespace

void add_to(device::DriverRegistry& registry) {
  device::Driver driver;
  driver.scheme = "forcedimension";
  driver.summary = "omega, delta, sigma, lambda and Falcon through Force Dimension's library";
  driver.arm.emplace();
  driver.arm->form = "forcedimension or forcedimension:SERIAL";
  driver.arm->names = [](std::string_view uri) { return settings_of(uri).has_value(); };
  driver.arm->open = open_arm;
  registry.add(std::move(driver));
}

}  // namespace palpate::drivers::forcedimension
