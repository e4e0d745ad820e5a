// What the error codes of HDAPI mean for whoever stands in front of the device, and what to do.
//
// Pure; any thread. Source of the codes' meaning: 3D Systems, OpenHaptics Toolkit API Reference Guide 3.4,
// "HDAPI error codes".
#pragma once

#include <cstdint>

#include "drivers/openhaptics/hd_abi.h"

namespace palpate::drivers::openhaptics {

enum class ErrorKind : std::uint8_t {
  none,
  force,   // the device has refused or cut a force and goes on: forces off for a moment, then ramped
  device,  // the device or the library cannot be used any more: close it, try to open it again
};

struct ErrorWords {
  ErrorKind kind;
  const char* name;  // as the maker calls it
  const char* reason;
  const char* remedy;
};

// Codes that nobody knows are of the device.
ErrorWords error_text(hd::ErrorCode code);

}  // namespace palpate::drivers::openhaptics
