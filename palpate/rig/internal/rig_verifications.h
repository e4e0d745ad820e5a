// The rig file's [[verification]] tables, read and written for rig.cpp. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/toml.h"
#include "palpate/rig/verification_record.h"

namespace palpate::rig {

std::vector<VerificationRecord> verifications_of(const TomlTable& file);
std::string verifications_text(const std::vector<VerificationRecord>& records);

}  // namespace palpate::rig
