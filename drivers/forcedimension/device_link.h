// An open device of the maker's library, as a thread of arms::ExchangedArm uses it.
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "drivers/forcedimension/arm.h"
#include "drivers/forcedimension/library.h"

namespace palpate::drivers::forcedimension {

// What is known of a device over all the times that it was opened.
struct KnownDevice {
  std::shared_ptr<Library> library;
  std::optional<int> serial;      // asked for; from the first time on that one's
  std::optional<ArmFacts> facts;  // since the first time
  std::atomic<std::uint64_t> saturations{0};
};

// A device that is open, and is given back at the end.
class OpenDevice {
 public:
  // The one of this serial number, or the first that can be opened. Refused: there is none, with what to do.
  static Expected<OpenDevice> find(std::shared_ptr<Library> library, std::optional<int> serial);
  OpenDevice(OpenDevice&& other) noexcept;
  OpenDevice& operator=(OpenDevice&&) = delete;
  ~OpenDevice();

  const dhd::Functions& dhd() const { return library_->dhd(); }
  char id() const { return id_; }
  const ArmFacts& facts() const { return facts_; }
  // The device lets go of what is older than kLongestHold from now on; false where it cannot.
  bool start_watchdog();

 private:
  OpenDevice(std::shared_ptr<Library> library, int id);
  std::shared_ptr<Library> library_;  // null: moved from
  char id_;
  ArmFacts facts_;
};

// `known` outlives the link.
Expected<std::unique_ptr<arms::ArmLink>> open_device(KnownDevice& known);

}  // namespace palpate::drivers::forcedimension
