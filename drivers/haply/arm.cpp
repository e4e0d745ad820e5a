#include "drivers/haply/arm.h"

#include <charconv>

#include "drivers/haply/service_link.h"

namespace palpate::drivers::haply {

struct HaplyArm::Told : ToldByService {};

Expected<std::unique_ptr<HaplyArm>> HaplyArm::open(const ArmSettings& settings) {
  auto told = std::make_unique<Told>();
  told->id = settings.id;
  auto arm = arms::ExchangedArm::open(
      {.loop = settings.loop, .name = "arm haply", .thread_name = "palpate-haply"},
      [service = settings.service, raw = told.get()] { return connect_to_service(service, *raw); });
  if (!arm) return tl::unexpected(arm.error());
  return std::unique_ptr<HaplyArm>(new HaplyArm(std::move(told), std::move(*arm)));
}

HaplyArm::HaplyArm(std::unique_ptr<Told> told, std::unique_ptr<arms::ExchangedArm> arm)
    : told_(std::move(told)), arm_(std::move(arm)) {}
HaplyArm::~HaplyArm() = default;

ArmStatus HaplyArm::status() const { return {{arm_->status()}, told_->bad_states.load()}; }
const std::string& HaplyArm::id() const { return told_->id; }

Json HaplyArm::config() const {
  const std::lock_guard lock(told_->guard);
  return told_->config;
}

std::optional<ArmSettings> settings_of(std::string_view uri) {
  constexpr std::string_view kDriver = "haply";
  if (!uri.starts_with(kDriver)) return std::nullopt;
  uri.remove_prefix(kDriver.size());
  ArmSettings settings;
  if (uri.empty()) return settings;
  if (uri.size() < 2 || uri.front() != ':') return std::nullopt;
  uri.remove_prefix(1);
  const auto at = uri.find('@');
  settings.id = std::string(uri.substr(0, at));
  if (at == std::string_view::npos) return settings;
  const auto where = uri.substr(at + 1);
  const auto colon = where.rfind(':');
  settings.service.host = std::string(where.substr(0, colon));
  if (settings.service.host.empty()) return std::nullopt;
  if (colon == std::string_view::npos) return settings;
  const auto port = where.substr(colon + 1);
  const auto [end, code] = std::from_chars(port.data(), port.data() + port.size(), settings.service.port);
  if (code != std::errc() || end != port.data() + port.size() || settings.service.port == 0)
    return std::nullopt;
  return settings;
}

}  // namespace palpate::drivers::haply
