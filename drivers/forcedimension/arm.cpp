#include "drivers/forcedimension/arm.h"

#include <charconv>

#include "drivers/forcedimension/device_link.h"

namespace palpate::drivers::forcedimension {
namespace {

constexpr const char* kName = "arm forcedimension";

tl::unexpected<Error> named(const Error& error) {
  return refused(error.code, "{}: {}", kName, error.message);
}

}  // namespace

struct ForceDimensionArm::Known : KnownDevice {};

Expected<std::unique_ptr<ForceDimensionArm>> ForceDimensionArm::open(const ArmSettings& settings) {
  auto library = Library::load(settings.library);
  if (!library) return tl::unexpected(library.error());
  auto known = std::make_unique<Known>();
  known->library = std::move(*library);
  known->serial = settings.serial;
  auto arm = arms::ExchangedArm::open({.loop = settings.loop, .name = kName, .thread_name = "palpate-dhd"},
                                      [raw = known.get()] { return open_device(*raw); });
  if (!arm) return named(arm.error());
  return std::unique_ptr<ForceDimensionArm>(new ForceDimensionArm(std::move(known), std::move(*arm)));
}

ForceDimensionArm::ForceDimensionArm(std::unique_ptr<Known> known, std::unique_ptr<arms::ExchangedArm> arm)
    : known_(std::move(known)), arm_(std::move(arm)) {}
ForceDimensionArm::~ForceDimensionArm() = default;

const ArmFacts& ForceDimensionArm::facts() const { return *known_->facts; }
std::uint64_t ForceDimensionArm::saturations() const { return known_->saturations.load(); }

std::optional<ArmSettings> settings_of(std::string_view uri) {
  constexpr std::string_view kDriver = "forcedimension";
  if (!uri.starts_with(kDriver)) return std::nullopt;
  uri.remove_prefix(kDriver.size());
  ArmSettings settings;
  if (uri.empty()) return settings;
  if (uri.front() != ':') return std::nullopt;
  uri.remove_prefix(1);
  unsigned short serial = 0;
  const auto [end, code] = std::from_chars(uri.data(), uri.data() + uri.size(), serial);
  if (code != std::errc() || end != uri.data() + uri.size()) return std::nullopt;
  settings.serial = serial;
  return settings;
}

Expected<ArmFacts> probe_arm(const ArmSettings& settings) {
  auto library = Library::load(settings.library);
  if (!library) return tl::unexpected(library.error());
  const auto device = OpenDevice::find(std::move(*library), settings.serial);
  if (!device) return named(device.error());
  return device->facts();
}

}  // namespace palpate::drivers::forcedimension
