#include "drivers/openhaptics/arm.h"

#include "drivers/openhaptics/connection.h"

namespace palpate::drivers::openhaptics {

Expected<std::unique_ptr<OpenHapticsArm>> OpenHapticsArm::open(const ArmSettings& settings) {
  auto library = Library::load(settings.library);
  if (!library) return tl::unexpected(library.error());
  auto connection = std::make_unique<Connection>(settings, std::move(*library));
  if (auto begun = connection->begin(); !begun) return tl::unexpected(begun.error());
  return std::unique_ptr<OpenHapticsArm>(new OpenHapticsArm(std::move(connection)));
}

OpenHapticsArm::OpenHapticsArm(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}

OpenHapticsArm::~OpenHapticsArm() {
  // A cycle that the library holds still uses it.
  if (!connection_->end()) [[maybe_unused]]
    auto* left = connection_.release();
}

device::ArmSample OpenHapticsArm::read() { return connection_->mailbox().read(); }
void OpenHapticsArm::command(const Vector3& force) { connection_->mailbox().command(force); }

void OpenHapticsArm::let_go() noexcept { connection_->mailbox().let_go(); }
ArmStatus OpenHapticsArm::status() const { return connection_->status(); }
const ArmFacts& OpenHapticsArm::facts() const { return connection_->facts(); }

std::optional<std::string> device_asked_for(std::string_view text) {
  constexpr std::string_view kDriver = "openhaptics";
  if (text == kDriver) return "";
  if (text.size() > kDriver.size() + 1 && text.starts_with(kDriver) && text[kDriver.size()] == ':')
    return std::string(text.substr(kDriver.size() + 1));
  return std::nullopt;
}

}  // namespace palpate::drivers::openhaptics
