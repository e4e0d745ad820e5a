// The forces' condition between memory and wire: which number means what stands here alone. Pure. Private to the messages.
#pragma once

#include <array>
#include <utility>

#include "palpate.pb.h"
#include "palpate/device/force_condition.h"
#include "palpate/transport/internal/wire_table.h"

namespace palpate::transport {

using device::ForceFault;
using device::ForceState;

inline constexpr std::array<std::pair<ForceState, wire::ForceState>, 4> kWireForceStates{
    {{ForceState::ready, wire::FORCE_STATE_READY},
     {ForceState::running, wire::FORCE_STATE_RUNNING},
     {ForceState::degraded, wire::FORCE_STATE_DEGRADED},
     {ForceState::safe, wire::FORCE_STATE_SAFE}}};

inline constexpr std::array<std::pair<ForceFault, wire::ForceFault>, 15> kWireForceFaults{
    {{ForceFault::none, wire::FORCE_FAULT_NONE},
     {ForceFault::stale_input, wire::FORCE_FAULT_STALE_INPUT},
     {ForceFault::bad_force, wire::FORCE_FAULT_BAD_FORCE},
     {ForceFault::bad_reading, wire::FORCE_FAULT_BAD_READING},
     {ForceFault::arm_silent, wire::FORCE_FAULT_ARM_SILENT},
     {ForceFault::outside_workspace, wire::FORCE_FAULT_OUTSIDE_WORKSPACE},
     {ForceFault::late_tick, wire::FORCE_FAULT_LATE_TICK},
     {ForceFault::button_released, wire::FORCE_FAULT_BUTTON_RELEASED},
     {ForceFault::overspeed, wire::FORCE_FAULT_OVERSPEED},
     {ForceFault::arm_lost, wire::FORCE_FAULT_ARM_LOST},
     {ForceFault::clamp_tripped, wire::FORCE_FAULT_CLAMP_TRIPPED},
     {ForceFault::law_failed, wire::FORCE_FAULT_LAW_FAILED},
     {ForceFault::arm_slow, wire::FORCE_FAULT_ARM_SLOW},
     {ForceFault::arm_unchecked, wire::FORCE_FAULT_ARM_UNCHECKED},
     {ForceFault::not_armed, wire::FORCE_FAULT_NOT_ARMED}}};

}  // namespace palpate::transport
