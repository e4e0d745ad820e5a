#include "drivers/haply/driver.h"

#include <fmt/format.h>

#include "drivers/arms/requests.h"
#include "drivers/haply/arm.h"

namespace palpate::drivers::haply {
namespace {

class OpenedHaplyArm : public device::OpenedArm {
 public:
  explicit OpenedHaplyArm(std::unique_ptr<HaplyArm> arm) : arm_(std::move(arm)) {}
  device::ArmDevice& device() override { return *arm_; }

  device::ArmFacts facts() const override {
    device::ArmFacts facts;
    facts.identity = fmt::format("haply inverse3 {}", arm_->id());
    facts.states_place = true;
    return facts;
  }
  // A real arm is worth waiting for: it never ends the server.
  std::optional<device::HealthReport> health() override { return arm_->status().health; }
  std::string description() const override { return fmt::format("arm haply: Inverse3 {}", arm_->id()); }

  Json figures() const override {
    const auto status = arm_->status();
    return {{"driver", "haply"},
            {"id", arm_->id()},
            {"config", arm_->config()},
            {"exchanges", status.exchanges},
            {"round_trip_us", 1e6 * status.round_trip_s},
            {"stale_exchanges", status.stale_exchanges},
            {"refused_commands", status.refused_commands},
            {"bad_states", status.bad_states},
            {"times_lost", status.times_lost}};
  }

 private:
  std::unique_ptr<HaplyArm> arm_;
};

Expected<std::unique_ptr<device::OpenedArm>> open_arm(const device::ArmRequest& request) {
  if (auto fine = arms::check_states_place(request); !fine) return tl::unexpected(fine.error());
  auto arm = HaplyArm::open(*settings_of(request.uri));
  if (!arm) return tl::unexpected(arm.error());
  return std::make_unique<OpenedHaplyArm>(std::move(*arm));
}

}  // namespace

void add_to(device::DriverRegistry& registry) {
  device::Driver driver;
  driver.scheme = "haply";
  driver.summary = "Haply's Inverse3 through the maker's service";
  driver.arm.emplace();
  driver.arm->form = "haply or haply:ID[@HOST:PORT]";
  driver.arm->names = [](std::string_view uri) { return settings_of(uri).has_value(); };
  driver.arm->open = open_arm;
  registry.add(std::move(driver));
}

}  // namespace palpate::drivers::haply
