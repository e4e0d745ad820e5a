// Opening a device through the maker's library, and what is said of one in a line.
//
// One ordinary thread at a time, under the library's calls().
#pragma once

#include <string>

#include "drivers/openhaptics/arm.h"
#include "drivers/openhaptics/library.h"

namespace palpate::drivers::openhaptics {

// "the default device", or its name.
std::string device_words(const std::string& name);
// One line for a person: what the maker's error means, and what to do.
std::string error_line(const std::string& name, hd::ErrorCode code, int internal);

// Newest error of the library's list, which is empty afterwards.
hd::ErrorInfo take_errors(const hd::Functions& hd);

struct Opened {
  hd::Handle handle = hd::kInvalidHandle;
  hd::Enum calibration_style = 0;
  ArmFacts facts;
};

// Opens the device and asks who it is; gives it back where it is refused.
Expected<Opened> open_device(Library& library, const std::string& name);

}  // namespace palpate::drivers::openhaptics
