#include "palpate/device/driver_registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <stdexcept>

#include "palpate/core/text.h"

namespace palpate::device {
namespace {

bool is_scheme(std::string_view text) {
  const auto letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !text.empty() && text.size() <= DriverRegistry::kLongestScheme && letter(text.front()) &&
         std::all_of(text.begin(), text.end(),
                     [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-'; });
}

template <typename O>
bool cannot_open(const std::optional<O>& opener) {
  return opener && !opener->open;
}

// What is wrong with a driver; empty: nothing.
std::string fault_of(const Driver& driver) {
  if (!is_scheme(driver.scheme))
    return "a scheme is lower-case letters, digits and '-', a letter first, at most 32 of them";
  if (driver.summary.empty() || driver.summary.find('\n') != std::string::npos)
    return "a summary of one line is expected";
  if (!driver.arm && !driver.tracker && !driver.camera && !driver.hand && !driver.display)
    return "it has no device of any kind";
  if (cannot_open(driver.arm) || cannot_open(driver.tracker) || cannot_open(driver.camera) ||
      cannot_open(driver.hand) || cannot_open(driver.display))
    return "a kind of device without a way to open it";
  return "";
}

// "a, b or c", in the order in which drivers were added.
template <typename O>
std::string forms(const std::vector<Driver>& drivers, std::optional<O> Driver::*kind, Offer offer) {
  std::vector<std::string> known;
  for (const Driver& driver : drivers)
    if (const auto& opener = driver.*kind;
        opener && !opener->form.empty() && !(offer == Offer::real && driver.simulated))
      known.push_back(opener->form);
  std::string text;
  for (std::size_t i = 0; i < known.size(); ++i) {
    // A form that offers a choice itself closes the list.
    const bool last = i + 1 == known.size() && known[i].find(" or ") == std::string::npos;
    text += (i == 0 ? "" : last ? " or " : ", ") + known[i];
  }
  return text;
}

// Null: the text names no such device.
template <typename O>
const O* named_by(const Driver* driver, std::optional<O> Driver::*kind, std::string_view uri, Offer offer) {
  if (driver == nullptr || !(driver->*kind) || (offer == Offer::real && driver->simulated)) return nullptr;
  const O& opener = *(driver->*kind);
  return opener.names && !opener.names(uri) ? nullptr : &opener;
}

// A guest's own call: what it throws is its refusal.
template <typename Result, typename Call>
Expected<Result> guarded(const std::string& uri, const Call& call) {
  try {
    return call();
  } catch (const std::exception& error) {
    return refused("device '{}': its driver fails: {}", excerpt(uri, 100), excerpt(error.what(), 200));
  }
}

template <typename O>
Expected<const O*> opener_for(const std::vector<Driver>& drivers, const Driver* driver,
                              std::optional<O> Driver::*kind, const std::string& uri) {
  if (const O* opener = named_by(driver, kind, uri, Offer::all)) return opener;
  const std::string known = forms(drivers, kind, Offer::all);
  if (known.empty())
    return wrong_use("is '{}'; this program has no driver for such a device", excerpt(uri, 100));
  return wrong_use("is '{}'; {} is expected", excerpt(uri, 100), known);
}

template <typename O>
Expected<void> checked(const O& opener, const typename O::Request& request) {
  if (!opener.check) return {};
  return guarded<void>(request.uri, [&] { return opener.check(request); });
}

template <typename O>
Expected<std::unique_ptr<typename O::Opened>> opened(const std::vector<Driver>& drivers, const Driver* driver,
                                                     std::optional<O> Driver::*kind,
                                                     const typename O::Request& request) {
  using Result = std::unique_ptr<typename O::Opened>;
  const auto opener = opener_for(drivers, driver, kind, request.uri);
  if (!opener) return tl::unexpected(opener.error());
  if (auto fine = checked(**opener, request); !fine) return tl::unexpected(fine.error());
  auto device = guarded<Result>(request.uri, [&] { return (*opener)->open(request); });
  if (device && !*device)
    return refused("device '{}': its driver opens nothing and does not say why", excerpt(request.uri, 100));
  return device;
}

template <typename O>
Expected<void> named(const std::vector<Driver>& drivers, const Driver* driver, std::optional<O> Driver::*kind,
                     const typename O::Request& request) {
  const auto opener = opener_for(drivers, driver, kind, request.uri);
  if (!opener) return tl::unexpected(opener.error());
  return checked(**opener, request);
}

}  // namespace

std::string_view scheme_of(std::string_view uri) { return uri.substr(0, uri.find(':')); }

std::string_view rest_of(std::string_view uri) {
  const auto colon = uri.find(':');
  return colon == std::string_view::npos ? std::string_view() : uri.substr(colon + 1);
}

void DriverRegistry::add(Driver driver) {
  std::string fault = fault_of(driver);
  if (fault.empty() && find(driver.scheme) != nullptr) fault = "there is another one of that scheme";
  if (!fault.empty()) throw std::invalid_argument(fmt::format("driver '{}': {}", driver.scheme, fault));
  drivers_.push_back(std::move(driver));
}

const Driver* DriverRegistry::find(std::string_view scheme) const {
  const auto found = std::find_if(drivers_.begin(), drivers_.end(),
                                  [&](const Driver& driver) { return driver.scheme == scheme; });
  return found == drivers_.end() ? nullptr : &*found;
}

std::string DriverRegistry::arm_forms(Offer offer) const { return forms(drivers_, &Driver::arm, offer); }
std::string DriverRegistry::tracker_forms(Offer offer) const {
  return forms(drivers_, &Driver::tracker, offer);
}
std::string DriverRegistry::camera_forms(Offer offer) const {
  return forms(drivers_, &Driver::camera, offer);
}
bool DriverRegistry::names_arm(std::string_view uri, Offer offer) const {
  return named_by(find_for(uri), &Driver::arm, uri, offer) != nullptr;
}
bool DriverRegistry::names_tracker(std::string_view uri, Offer offer) const {
  return named_by(find_for(uri), &Driver::tracker, uri, offer) != nullptr;
}
bool DriverRegistry::names_camera(std::string_view uri, Offer offer) const {
  return named_by(find_for(uri), &Driver::camera, uri, offer) != nullptr;
}

Expected<void> DriverRegistry::check(const ArmRequest& request) const {
  return named(drivers_, find_for(request.uri), &Driver::arm, request);
}
Expected<void> DriverRegistry::check(const TrackerRequest& request) const {
  return named(drivers_, find_for(request.uri), &Driver::tracker, request);
}
Expected<void> DriverRegistry::check(const CameraRequest& request) const {
  return named(drivers_, find_for(request.uri), &Driver::camera, request);
}

Expected<std::unique_ptr<OpenedArm>> DriverRegistry::open(const ArmRequest& request) const {
  return opened(drivers_, find_for(request.uri), &Driver::arm, request);
}
Expected<std::unique_ptr<OpenedTracker>> DriverRegistry::open(const TrackerRequest& request) const {
  return opened(drivers_, find_for(request.uri), &Driver::tracker, request);
}
Expected<std::unique_ptr<OpenedCamera>> DriverRegistry::open(const CameraRequest& request) const {
  return opened(drivers_, find_for(request.uri), &Driver::camera, request);
}
Expected<std::unique_ptr<OpenedHand>> DriverRegistry::open(const HandRequest& request) const {
  return opened(drivers_, find_for(request.uri), &Driver::hand, request);
}
Expected<std::unique_ptr<OpenedDisplay>> DriverRegistry::open(const DisplayRequest& request) const {
  return opened(drivers_, find_for(request.uri), &Driver::display, request);
}

}  // namespace palpate::device
