// Whether an arm that a driver has opened is one that a rig's calibration can be about.
//
// Refused in words: another number of joints, joints in place of a place, motors' limits that are none.
#pragma once

#include <string>

#include "palpate/device/opened.h"
#include "palpate/rig/rig.h"

namespace palpate::haptics {

Expected<void> check_arm(const rig::Rig& rig, device::OpenedArm& arm, const std::string& uri);

}  // namespace palpate::haptics
