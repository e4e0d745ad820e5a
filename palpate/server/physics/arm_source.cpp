#include "palpate/server/physics/arm_source.h"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/laboratory/channel.h"
#include "drivers/openhaptics/arm.h"
#include "palpate/core/text.h"

namespace palpate::server::physics {
namespace {

class LabArmSource : public ArmSource {
 public:
  LabArmSource(std::shared_ptr<drivers::laboratory::LabClient> client,
               std::unique_ptr<drivers::laboratory::LabArm> arm)
      : client_(std::move(client)), arm_(std::move(arm)) {}
  device::ArmDevice& device() override { return *arm_; }
  haptics::ForceLimits limits(const haptics::ForceLimits& wanted) const override { return wanted; }
  Expected<std::optional<std::string>> look() override {
    if (auto alive = client_->check(); !alive) return tl::unexpected(alive.error());
    if (client_->silent() == told_silent_) return std::nullopt;
    told_silent_ = client_->silent();
    return told_silent_
               ? fmt::format("laboratory '{}' stands still: no forces until it goes on", client_->name())
               : fmt::format("laboratory '{}' goes on", client_->name());
  }
  Json figures() const override { return nullptr; }

 private:
  std::shared_ptr<drivers::laboratory::LabClient> client_;
  std::unique_ptr<drivers::laboratory::LabArm> arm_;
  bool told_silent_ = false;
};

class OpenHapticsSource : public ArmSource {
 public:
  explicit OpenHapticsSource(std::unique_ptr<drivers::openhaptics::OpenHapticsArm> arm)
      : arm_(std::move(arm)) {}
  device::ArmDevice& device() override { return *arm_; }

  haptics::ForceLimits limits(const haptics::ForceLimits& wanted) const override {
    haptics::ForceLimits limits = wanted;
    limits.peak_n = std::min(limits.peak_n, arm_->facts().peak_n);
    if (arm_->facts().continuous_n > 0.0)
      limits.continuous_n = std::min(limits.continuous_n, arm_->facts().continuous_n);
    return limits;
  }

  // A real arm is worth waiting for: it never ends the server.
  Expected<std::optional<std::string>> look() override {
    const auto status = arm_->status();
    const bool first = !told_;
    if (told_ == status.condition) return std::nullopt;
    const bool was_gone = told_ == drivers::openhaptics::ArmCondition::gone;
    told_ = status.condition;
    if (status.condition != drivers::openhaptics::ArmCondition::running) return status.message;
    const auto& facts = arm_->facts();
    return first ? fmt::format("arm openhaptics: {} (serial {}, {:.1f} N), {}", facts.model, facts.serial,
                               facts.peak_n, facts.library)
           : was_gone ? "arm openhaptics: works again; see that it still knows where it is, then "
                        "`palpate status --reset` lets forces come back"
                      : "arm openhaptics: works again";
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
  std::unique_ptr<drivers::openhaptics::OpenHapticsArm> arm_;
  std::optional<drivers::openhaptics::ArmCondition> told_;
};

Expected<std::unique_ptr<ArmSource>> open_lab_arm(const std::string& lab) {
  auto client = drivers::laboratory::LabClient::open(lab);
  if (!client) return tl::unexpected(client.error());
  auto arm = drivers::laboratory::LabArm::open(*client);
  if (!arm) return tl::unexpected(arm.error());
  return std::make_unique<LabArmSource>(std::move(*client), std::move(*arm));
}

}  // namespace

Expected<std::unique_ptr<ArmSource>> open_arm(const ArmChoice& choice) {
  if (choice.text == "lab") return open_lab_arm(choice.lab);
  const auto name = drivers::openhaptics::device_asked_for(choice.text);
  if (!name)
    return wrong_use("--arm: is '{}'; lab, openhaptics or openhaptics:NAME is expected",
                     excerpt(choice.text));
  drivers::openhaptics::ArmSettings settings;
  settings.name = *name;
  settings.lengths = choice.lengths;
  settings.at_reset_position = choice.at_reset_position;
  auto arm = drivers::openhaptics::OpenHapticsArm::open(settings);
  if (!arm) return tl::unexpected(arm.error());
  return std::make_unique<OpenHapticsSource>(std::move(*arm));
}

}  // namespace palpate::server::physics
