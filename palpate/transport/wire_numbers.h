// Which number of palpate.proto an enumeration of ours has: for recordings, whose messages use the same ones. Pure; a number that
// means nothing here is nothing.
#pragma once

#include <optional>

#include "palpate/device/force_condition.h"
#include "palpate/device/health.h"
#include "palpate/scene/application.h"

namespace palpate::transport {

int wire_number(device::ForceState state);
int wire_number(device::ForceFault fault);
int wire_number(device::HealthCode code);
int wire_number(scene::Control control);

std::optional<device::ForceState> force_state_of(int number);
std::optional<device::ForceFault> force_fault_of(int number);
std::optional<device::HealthCode> health_code_of(int number);
std::optional<scene::Control> control_of(int number);

}  // namespace palpate::transport
