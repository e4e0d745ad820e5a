// The rig file's part [forces], read and written for rig.cpp. Pure functions.
#pragma once

#include <optional>
#include <string>

#include "palpate/core/toml.h"
#include "palpate/rig/force_calibration.h"

namespace palpate::rig {

std::optional<ForceCalibration> forces_of(const TomlTable& table);
std::string forces_text(const std::optional<ForceCalibration>& forces);

}  // namespace palpate::rig
