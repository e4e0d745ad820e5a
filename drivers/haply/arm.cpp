#include "drivers/haply/arm.h"

#include <charconv>

#include "drivers/haply/connection.h"

namespace palpate::drivers::haply {

Expected<std::unique_ptr<HaplyArm>> HaplyArm::open(const ArmSettings& settings) {
  auto connection = std::make_unique<Connection>(settings);
  if (auto begun = connection->begin(); !begun) return tl::unexpected(begun.error());
  return std::unique_ptr<HaplyArm>(new HaplyArm(std::move(connection)));
}

HaplyArm::HaplyArm(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}
HaplyArm::~HaplyArm() = default;

device::ArmSample HaplyArm::read() { return connection_->read(); }
void HaplyArm::command(const Vector3& force) { connection_->command(force); }
void HaplyArm::let_go() noexcept { connection_->let_go(); }
ArmStatus HaplyArm::status() const { return connection_->status(); }
const std::string& HaplyArm::id() const { return connection_->id(); }
Json HaplyArm::config() const { return connection_->config(); }

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
