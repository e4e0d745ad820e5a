// Where the physics server's arm comes from: the simulated laboratory's, or a real one through its driver.
//
// The place that knows both; the server itself sees an ArmDevice. One ordinary thread.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/devices.h"
#include "palpate/device/phantom.h"
#include "palpate/haptics/force_limits.h"

namespace palpate::server::physics {

class ArmSource {
 public:
  virtual ~ArmSource() = default;
  virtual device::ArmDevice& device() = 0;
  // The limits of the force chain for this arm: never above `wanted`.
  virtual haptics::ForceLimits limits(const haptics::ForceLimits& wanted) const = 0;
  // To be called some ten times a second. Refused: the arm is gone for good, and the server ends. Otherwise a
  // line for a person where something has changed, such as an arm that was unplugged.
  virtual Expected<std::optional<std::string>> look() = 0;
  // What happened to it, for the server's figures; null where there is nothing to tell.
  virtual Json figures() const = 0;
};

struct ArmChoice {
  std::string text = "lab";        // "lab", "openhaptics" or "openhaptics:NAME"
  std::string lab = "lab";         // which laboratory's
  device::PhantomLengths lengths;  // the maker's, of a real arm
  bool at_reset_position = false;  // a person says so: encoders that have lost their zero may be set
};

// Wrong use: a choice that is none. Refused: an arm that cannot be had.
Expected<std::unique_ptr<ArmSource>> open_arm(const ArmChoice& choice);

}  // namespace palpate::server::physics
