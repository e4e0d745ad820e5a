// The arm whose readings a recording holds.
#pragma once

#include <filesystem>
#include <optional>

#include "palpate/device/arm_model.h"

namespace palpate::record::session {

// As its maker describes it, by the rig that was recorded beside it; nothing where there is none, or none that can be read.
std::optional<device::ArmModel> recorded_arm(const std::filesystem::path& recording);

}  // namespace palpate::record::session
