// What a tracker's markers are called in tables, recordings and options. Pure functions, any thread.
#pragma once

#include <optional>
#include <string>

#include "palpate/device/devices.h"

namespace palpate::device {

// "tip_marker", "camera_marker", "pointer"; nothing for another name.
std::optional<MarkerId> marker_named(const std::string& name);
std::string name_of_marker(MarkerId marker);

}  // namespace palpate::device
