#include "drivers/openhaptics/driver.h"

#include <fmt/format.h>

#include "drivers/openhaptics/arm.h"

namespace palpate::drivers::openhaptics {
namespace {

class OpenedOpenHapticsArm : public device::OpenedArm {
 public:
  explicit OpenedOpenHapticsArm(std::unique_ptr<OpenHapticsArm> arm) : arm_(std::move(arm)) {}
  device::ArmDevice& device() override { return *arm_; }

  device::ArmFacts facts() const override {
    const auto& facts = arm_->facts();
    device::ArmFacts said;
    said.identity = fmt::format("openhaptics {} {}", facts.model, facts.serial);
    said.peak_n = facts.peak_n;
    if (facts.continuous_n > 0.0) said.continuous_n = facts.continuous_n;
    return said;
  }

  // A real arm is worth waiting for: it never ends the server.
  std::optional<device::HealthReport> health() override { return arm_->status().health; }

  std::string description() const override {
    const auto& facts = arm_->facts();
    return fmt::format("arm openhaptics: {} (serial {}, {:.1f} N), {}", facts.model, facts.serial,
                       facts.peak_n, facts.library);
  }

  Json figures() const override {
    const auto status = arm_->status();
    const auto& facts = arm_->facts();
    return {{"driver", "openhaptics"},
            {"model", facts.model},
            {"serial", facts.serial},
            {"library", facts.library},
            {"peak_n", facts.peak_n},
            {"continuous_n", facts.continuous_n},
            {"cycles", status.cycles},
            {"force_errors", status.force_errors},
            {"stale_cycles", status.stale_cycles},
            {"refused_commands", status.refused_commands},
            {"times_lost", status.times_lost}};
  }

 private:
  std::unique_ptr<OpenHapticsArm> arm_;
};

Expected<std::unique_ptr<device::OpenedArm>> open_arm(const device::ArmRequest& request) {
  if (request.nominal.kind != device::ArmModel::Kind::phantom)
    return refused(
        "{}: has the kinematics of a PHANToM, the rig's arm {} is {}; a rig of this arm is expected",
        request.uri, request.nominal.name,
        request.nominal.kind == device::ArmModel::Kind::dh
            ? fmt::format("a chain of {} joints", request.nominal.joint_count())
            : std::string("one that states its place"));
  ArmSettings settings;
  settings.name = device_asked_for(request.uri).value_or("");
  settings.lengths = request.nominal.lengths;
  settings.at_reset_position = request.at_reset_position;
  auto arm = OpenHapticsArm::open(settings);
  if (!arm) return tl::unexpected(arm.error());
  return std::make_unique<OpenedOpenHapticsArm>(std::move(*arm));
}

}  // namespace

void add_to(device::DriverRegistry& registry) {
  device::Driver driver;
  driver.scheme = "openhaptics";
  driver.summary = "PHANToM and Touch arms through the maker's library";
  driver.arm.emplace();
  driver.arm->form = "openhaptics or openhaptics:NAME";
  driver.arm->names = [](std::string_view uri) { return device_asked_for(uri).has_value(); };
  driver.arm->open = open_arm;
  registry.add(std::move(driver));
}

}  // namespace palpate::drivers::openhaptics
